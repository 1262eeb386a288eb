//! Watching a robot elsewhere.

use std::{sync::Arc, thread};

use serde_json::json;
use visloc_studio::{
    Clock, Command, MessageBuilder, MessageKind, Session as _, Update,
    server::{Remote, RemoteSession},
};

use crate::server::{hub, serve, wait_for};

fn update(number: u32) -> Update {
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
