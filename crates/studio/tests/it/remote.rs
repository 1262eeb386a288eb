//! Watching a robot elsewhere.

use std::{sync::Arc, thread};

use serde_json::json;
use visloc_core::Clock;
use visloc_studio::{
    Command, MessageBuilder, MessageKind, Session as _, Update,
    server::{Remote, RemoteSession},
};

use crate::server::{hub, serve, wait_for};

pub fn update(number: u32) -> Update {
    let bytes = |kind, header| -> Arc<[u8]> { MessageBuilder::new(kind, &header).unwrap().finish().into() };
    Update {
        scene: bytes(MessageKind::Scene, json!({ "mode": "watch" })),
        state: bytes(MessageKind::State, json!({ "number": number })),
        image: None,
    }
}

fn number(hub: &visloc_studio::Hub) -> Option<u64> {
    let latest = hub.latest()?;
    visloc_studio::Message::read(&latest.state).ok()?.header.get("number")?.as_u64()
}

#[test]
fn updates_come_over_and_commands_go_back_and_a_broken_link_is_mended() {
    let (robot, robot_commands) = hub();
    let server = serve(&robot, "127.0.0.1:0", Some("secret"));
    let address = server.address().to_string();
    let (desk, desk_commands) = hub();
    let watching = Arc::clone(&desk);
    let remote = Remote { address: address.clone(), token: Some("secret".to_owned()) };
    let link = thread::spawn(move || remote.watch(&watching, &desk_commands).unwrap());

    robot.publish(update(41));
    wait_for("the update comes over", || number(&desk) == Some(41));
    desk.take_text("{\"type\":\"forget\"}");
    wait_for("the command goes back", || robot_commands.try_iter().any(|it| it == Command::Forget {}));

    drop(server);
    let notice = || desk.latest().is_some_and(|latest| latest.state.windows(6).any(|six| six == b"notice"));
    wait_for("the break is told", notice);
    let _again = serve(&robot, &address, Some("secret"));
    robot.publish(update(42));
    wait_for("the link is mended", || number(&desk) == Some(42));
    desk.close();
    link.join().unwrap();
}

/// A number of the state that the pages here are shown.
fn stale_secs(hub: &visloc_studio::Hub) -> Option<f64> {
    let latest = hub.latest()?;
    visloc_studio::Message::read(&latest.state).ok()?.header.get("stale_secs")?.as_f64()
}

/// Takes what connects to the robot, passes on what it says until told to stop, and then holds the connection without a word.
fn stalling_link(robot: std::net::SocketAddr) -> (std::net::SocketAddr, Arc<std::sync::atomic::AtomicBool>) {
    use std::io::{Read as _, Write as _};
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let stalls = Arc::new(std::sync::atomic::AtomicBool::new(false));
    let is_stalled = Arc::clone(&stalls);
    thread::spawn(move || {
        let (near, _) = listener.accept().unwrap();
        let far = std::net::TcpStream::connect(robot).unwrap();
        let pass = |mut from: std::net::TcpStream, mut to: std::net::TcpStream| {
            let is_stalled = Arc::clone(&is_stalled);
            thread::spawn(move || {
                let mut bytes = [0; 4096];
                while let Ok(count @ 1..) = from.read(&mut bytes) {
                    while is_stalled.load(std::sync::atomic::Ordering::Relaxed) {
                        thread::sleep(std::time::Duration::from_millis(10));
                    }
                    if to.write_all(&bytes[..count]).is_err() {
                        return;
                    }
                }
            });
        };
        pass(near.try_clone().unwrap(), far.try_clone().unwrap());
        pass(far, near);
    });
    (address, stalls)
}

/// Within a second and a half the pages here know that a link has stalled, and that the robot's program has while its server answers;
/// a robot that waits for its next image is neither.
#[test]
fn what_stalls_is_stale_and_what_waits_is_not() {
    let secs = Arc::new(std::sync::atomic::AtomicU32::new(0));
    let now = Arc::clone(&secs);
    let clock = Clock::new(move || f64::from(now.load(std::sync::atomic::Ordering::Relaxed)));
    let (robot, _robot_commands) = visloc_studio::Hub::new(clock, |_| {});
    let server = serve(&robot, "127.0.0.1:0", Some("secret"));
    let (address, stalls) = stalling_link(server.address());
    let (desk, desk_commands) = hub();
    let watching = Arc::clone(&desk);
    let remote = Remote { address: address.to_string(), token: Some("secret".to_owned()) };
    let link = thread::spawn(move || remote.watch(&watching, &desk_commands).unwrap());
    robot.publish(update(1));
    wait_for("the update comes over", || number(&desk) == Some(1));
    thread::sleep(std::time::Duration::from_millis(1600));
    assert_eq!(stale_secs(&desk), None, "the robot waits for its next image");

    // A second and a half, and as much again for a busy machine.
    let within = |what: &str, is_so: &dyn Fn() -> bool| {
        let comes = (0..120).any(|_| {
            thread::sleep(std::time::Duration::from_millis(25));
            is_so()
        });
        assert!(comes, "{what}");
    };
    robot.work();
    secs.store(2, std::sync::atomic::Ordering::Relaxed);
    within("the engine hangs", &|| stale_secs(&desk).is_some_and(|secs| secs > 1.0));
    robot.rest();
    within("it goes on", &|| stale_secs(&desk).is_none() && number(&desk) == Some(1));
    stalls.store(true, std::sync::atomic::Ordering::Relaxed);
    within("the link stalls", &|| stale_secs(&desk).is_some());
    assert_eq!(number(&desk), Some(1), "what was shown stays");
    stalls.store(false, std::sync::atomic::Ordering::Relaxed);
    robot.publish(update(2));
    within("the link is there again", &|| stale_secs(&desk).is_none() && number(&desk) == Some(2));
    desk.close();
    link.join().unwrap();
}

#[test]
fn a_robot_elsewhere_is_a_scene_among_others() {
    let (robot, robot_commands) = hub();
    let server = serve(&robot, "127.0.0.1:0", Some("secret"));
    let remote = Remote { address: server.address().to_string(), token: Some("secret".to_owned()) };
    let scenes = json!([{ "id": "robot", "group": "Robot", "label": "robot" }]);
    let mut session = RemoteSession::open(remote, "robot", scenes.clone(), Clock::still(), |_| {}).unwrap();
    assert!(crate::support::state(&mut session)["notice"].as_str().unwrap().contains("connecting"));
    robot.publish(update(7));
    let mut session = std::cell::RefCell::new(session);
    wait_for("the update comes over", || {
        let mut session = session.borrow_mut();
        session.step().unwrap();
        session.has_news() && crate::support::state(&mut *session)["number"] == json!(7)
    });
    let session = session.get_mut();
    session.step().unwrap();
    assert!(!session.has_news(), "nothing new has come");
    let scene = crate::support::scene(&session.update(None).unwrap());
    assert_eq!((&scene["scene"], &scene["scenes"]), (&json!("robot"), &scenes));
    let aside = json!({ "notice": null, "recorder": { "is_on": true } });
    let state = visloc_studio::Message::read(&session.update(Some(&aside)).unwrap().state).unwrap().header;
    assert_eq!(state["recorder"], aside["recorder"]);
    assert!(!state.contains_key("notice"), "what the robot says is not hidden");
    session.handle(&Command::Save {}).unwrap();
    wait_for("the command goes there", || robot_commands.try_iter().any(|it| it == Command::Save {}));
}
