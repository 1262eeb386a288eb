//! A robot elsewhere is driven over the link.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering},
    },
    time::Duration,
};

use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::Message as Frame;
use visloc_core::Clock;
use visloc_studio::{
    Command, Hub, Session as _,
    server::{DriveLimits, Remote, RemoteSession, Server, Wheel},
};

use crate::{
    server::{Page, open, serve, wait_for},
    support::{command_of, state},
};

/// A robot that may be driven, at 0.1 m/s ahead, and its clock in milliseconds.
struct Robot {
    wheel: Arc<Wheel>,
    hub: Arc<Hub>,
    server: Server,
    ms: Arc<AtomicU32>,
}

fn robot() -> Robot {
    let ms = Arc::new(AtomicU32::new(5_000));
    let now = Arc::clone(&ms);
    let clock = Clock::new(move || f64::from(now.load(Ordering::Relaxed)) / 1e3);
    let limits = DriveLimits { speed_m_per_s: 0.1, turn_rad_per_s: 0.5 };
    let wheel = Arc::new(Wheel::new(limits, clock.clone()));
    let (hub, _commands) = Hub::new(clock, |_| {});
    hub.let_drive(Arc::clone(&wheel));
    let server = serve(&hub, "127.0.0.1:0", Some("secret"));
    Robot { wheel, hub, server, ms }
}

fn ahead(seen_secs: f64) -> Value {
    json!({ "type": "drive", "forward": 1.0, "left": 0.0, "turn": 0.0, "seen_secs": seen_secs })
}

fn say(page: &mut Page, command: &Value) {
    page.send(Frame::text(command.to_string())).unwrap();
}

/// Why a page was refused.
fn refusal(page: &mut Page) -> String {
    loop {
        let Frame::Text(text) = page.read().unwrap() else { continue };
        let told: Value = serde_json::from_str(&text).unwrap();
        if told["type"] == "refused" {
            return told["reason"].as_str().unwrap().to_owned();
        }
    }
}

#[test]
fn one_drives_the_other_is_told_who_and_a_lost_link_is_a_stop() {
    let robot = robot();
    let mut first = open(&robot.server, None, "?token=secret").unwrap();
    let mut second = open(&robot.server, None, "?token=secret").unwrap();
    say(&mut first, &ahead(4.9));
    wait_for("it goes", || robot.wheel.order().is_driven);
    assert_eq!(robot.wheel.order().speeds, [0.1, 0.0, 0.0], "no faster than the robot says");
    say(&mut second, &ahead(4.9));
    let who = first.get_ref().local_addr().unwrap().to_string();
    let told = refusal(&mut second);
    assert!(told.starts_with(&format!("{who} drives")), "{told}");
    assert_eq!(robot.wheel.fields()["driver"], json!(who));

    // Nobody says anything for half a second: the clock stands until it is moved.
    robot.ms.fetch_add(500, Ordering::Relaxed);
    assert!(!robot.wheel.order().is_driven, "the link is silent");
    say(&mut first, &ahead(5.4));
    wait_for("it goes on", || robot.wheel.order().is_driven);
    drop(first);
    wait_for("the link is closed: it stands, though no time has passed", || !robot.wheel.order().is_driven);
    say(&mut second, &ahead(5.4));
    wait_for("then the other one may", || robot.wheel.order().is_driven);
}

#[test]
fn what_was_held_up_on_the_way_moves_nothing() {
    let robot = robot();
    let mut page = open(&robot.server, None, "?token=secret").unwrap();
    for _ in 0..50 {
        say(&mut page, &ahead(2.0));
    }
    let told = refusal(&mut page);
    assert!(told.contains("3.0 s old") && !robot.wheel.order().is_driven, "{told}");
}

#[test]
fn a_desk_passes_on_who_drives_and_what_is_refused() {
    let robot = robot();
    let open_desk = || {
        let address = robot.server.address().to_string();
        let remote = Remote { address, token: Some("secret".to_owned()) };
        RemoteSession::open(remote, "robot", json!([]), Clock::still(), |_| {}).unwrap()
    };
    robot.hub.publish(crate::remote::update(1));
    let (mut desk, mut other) = (open_desk(), open_desk());
    wait_for("both are there", || robot.hub.num_viewers() == 2);
    let head = json!({ "type": "head", "yaw_deg": 30.0, "pitch_deg": 10.0 });
    for command in [&ahead(4.5), &head] {
        desk.handle(&command_of(command.clone())).unwrap();
    }
    wait_for("it goes and looks aside", || {
        let order = robot.wheel.order();
        order.is_driven && order.head.is_some()
    });
    other.handle(&command_of(ahead(4.5))).unwrap();
    let told = (0..400).find_map(|_| {
        std::thread::sleep(Duration::from_millis(25));
        other.step().unwrap();
        state(&mut other)["notice"].as_str().filter(|notice| notice.contains(" drives")).map(str::to_owned)
    });
    assert!(told.is_some());
    drop(desk);
    wait_for("the desk is gone", || !robot.wheel.order().is_driven);
}

/// A playground has no wheel: there somebody who leaves with a key held must not leave the robot walking either.
#[test]
fn who_leaves_a_playground_with_a_key_held_leaves_it_standing() {
    let (hub, commands) = crate::server::hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    let mut page = open(&server, None, "").unwrap();
    say(&mut page, &json!({ "type": "drive", "forward": 1.0, "left": 0.0, "turn": 0.0 }));
    let next = || commands.recv_timeout(Duration::from_secs(10)).unwrap();
    assert_eq!(next(), Command::Hello {});
    assert!(matches!(next(), Command::Drive { forward: 1.0, .. }));
    drop(page);
    assert!(matches!(next(), Command::Drive { forward: 0.0, left: 0.0, turn: 0.0, .. }));
}
