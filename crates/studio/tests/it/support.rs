//! What several tests need.

use serde_json::{Map, Value, json};
use visloc_core::Clock;
use visloc_studio::{Command, Message, Session, Update, playground::Playground};

pub fn playground(place: &str, seed: u64) -> Playground {
    Playground::new(place, seed, Clock::still(), json!([])).unwrap()
}

/// Tells a session something, as a page would.
pub fn tell(session: &mut dyn Session, command: Value) {
    session.handle(&command_of(command)).unwrap();
}

pub fn command_of(command: Value) -> Command {
    serde_json::from_value(command).unwrap()
}

/// The header of the present state.
pub fn state(session: &mut dyn Session) -> Map<String, Value> {
    Message::read(&session.update(None).unwrap().state).unwrap().header
}

pub fn scene(update: &Update) -> Map<String, Value> {
    Message::read(&update.scene).unwrap().header
}

pub fn steps(session: &mut dyn Session, count: usize) {
    (0..count).for_each(|_| session.step().unwrap());
}

/// Steps until the state is as wished; the number of steps.
pub fn step_until(
    session: &mut dyn Session,
    most: usize,
    is_wished: impl Fn(&Map<String, Value>) -> bool,
) -> usize {
    for i in 0..most {
        if is_wished(&state(session)) {
            return i;
        }
        session.step().unwrap();
    }
    panic!("not after {most} steps: {:?}", state(session).get("contenders"));
}

/// Whether every algorithm knows the place and is right.
pub fn all_localized(state: &Map<String, Value>) -> bool {
    state["contenders"].as_array().unwrap().iter().all(|contender| {
        contender["is_localized"] == json!(true) && contender["error"][0].as_f64().is_some_and(|m| m < 0.2)
    })
}

/// Where the robot is.
pub fn truth(state: &Map<String, Value>) -> [f64; 3] {
    [0, 1, 2].map(|i| state["truth"]["pose"][i].as_f64().unwrap())
}
