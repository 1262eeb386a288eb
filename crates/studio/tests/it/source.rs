//! Any source in the studio.

use std::sync::Arc;

use serde_json::json;
use visloc_core::Clock;
use visloc_sim::{Scenario, Simulation};
use visloc_studio::{
    Session, StudioError,
    source::{FramesOpener, OpenRun, SourceSession},
};

use crate::support::{command_of, scene, state, tell};

const NUM_FRAMES: usize = 20;
/// A walk that sees lines from the first image on: without any the filter has no particles yet.
const SEED: u64 = 2;

fn opener() -> FramesOpener {
    Arc::new(|seed| {
        let simulation = Simulation::new(&Scenario::load("tour")?, seed)?.with_num_frames(NUM_FRAMES);
        Ok(OpenRun { map: simulation.map().clone(), frames: Box::new(simulation) })
    })
}

fn session() -> SourceSession {
    let more = json!({ "scene": "source-0", "scenes": [] });
    SourceSession::open("sim:tour", opener(), false, &more, Clock::still(), SEED).unwrap()
}

/// Steps to the end; the number of the last frame.
fn to_the_end(session: &mut SourceSession) -> u64 {
    while session.step_secs().is_some() {
        session.step().unwrap();
        std::thread::yield_now();
    }
    state(session)["number"].as_u64().unwrap()
}

#[test]
fn a_source_is_followed_to_its_end_and_from_the_beginning_again() {
    let mut session = session();
    assert_eq!(state(&mut session)["is_waiting"], json!(true), "nothing has come yet");
    assert!(session.input().is_none());
    assert_eq!(to_the_end(&mut session), NUM_FRAMES as u64 - 1);
    let last = state(&mut session);
    assert_eq!((&last["is_playing"], last["contenders"].as_array().unwrap().len()), (&json!(false), 1));
    assert!(session.input().is_some());
    tell(&mut session, json!({ "type": "play" }));
    assert_eq!(state(&mut session)["is_playing"], json!(true));
    to_the_end(&mut session);
    let again = state(&mut session);
    assert_eq!(again["contenders"], last["contenders"], "the same seed gives the same run");
    tell(&mut session, json!({ "type": "reset", "seed": SEED + 1 }));
    to_the_end(&mut session);
    assert_ne!(state(&mut session)["truth"], last["truth"]);
}

#[test]
fn algorithms_and_parameters_are_changed() {
    let mut session = session();
    tell(&mut session, json!({ "type": "algorithms", "names": ["mc", "evolutionary"] }));
    tell(&mut session, json!({ "type": "parameter", "algorithm": 0, "path": "num_particles", "value": 55 }));
    to_the_end(&mut session);
    assert_eq!(state(&mut session)["contenders"][0]["num_individuals"], json!(55));
    let scene = scene(&session.update(None).unwrap());
    assert_eq!(
        (&scene["mode"], &scene["contenders"][0]["changed"]),
        (&json!("source"), &json!(["num_particles"]))
    );
    for wrong in [
        json!({ "type": "kidnap" }),
        json!({ "type": "seek", "frame": 1 }),
        json!({ "type": "algorithms", "names": [] }),
    ] {
        assert!(session.handle(&command_of(wrong.clone())).is_err(), "{wrong}");
    }
}

#[test]
fn what_cannot_be_opened_is_told() {
    let nowhere: FramesOpener = Arc::new(|_| Err(StudioError::input("x.mcap", "not there")));
    let error = SourceSession::open("x", nowhere, true, &json!({}), Clock::still(), 1).err().unwrap();
    assert_eq!(error.to_string(), "x.mcap: not there");
}
