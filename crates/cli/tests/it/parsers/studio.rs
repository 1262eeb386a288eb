//! What pages and robots elsewhere send, and recordings of the studio.

use std::{cell::RefCell, fs};

use serde_json::json;
use visloc_core::Clock;
use visloc_studio::{
    Command, Message, MessageBuilder, MessageKind, Session, Update,
    playground::Playground,
    recording::{Input, Recorder},
    replay::Replay,
    server::answer_to,
};

use super::{as_file, bags, in_folder};

thread_local! {
    static PLAYGROUND: RefCell<Playground> =
        RefCell::new(Playground::new("robocup-2010", 1, Clock::still(), json!([])).unwrap());
}

/// One command a line.
pub fn command_seeds() -> Vec<Vec<u8>> {
    let all = [
        json!({ "type": "play" }),
        json!({ "type": "speed", "factor": 2.0 }),
        json!({ "type": "drive", "forward": 1.0, "left": -0.5, "turn": 0.1 }),
        json!({ "type": "walk_to", "x_m": 1.0, "y_m": -2.0 }),
        json!({ "type": "head", "yaw_deg": 20.0, "pitch_deg": 10.0 }),
        json!({ "type": "carry", "x_m": 0.5, "y_m": 0.5, "yaw_rad": 1.0 }),
        json!({ "type": "put_down" }),
        json!({ "type": "kidnap", "x_m": -1.5, "y_m": 1.0 }),
        json!({ "type": "light", "exposure_stops": 0.5, "unevenness": 0.2 }),
        json!({ "type": "odometry", "factor": 1.5 }),
        json!({ "type": "robots", "count": 2 }),
        json!({ "type": "algorithms", "names": ["mc"] }),
        json!({ "type": "parameter", "algorithm": 0, "path": "motion.noise_m_per_m", "value": 0.3 }),
        json!({ "type": "parameter", "path": "analysis.num_columns", "value": 40 }),
        json!({ "type": "defaults" }),
        json!({ "type": "seek", "frame": 1 }),
        json!({ "type": "reset", "seed": 3 }),
    ];
    let lines: Vec<String> = all.iter().map(ToString::to_string).collect();
    let mut seeds: Vec<Vec<u8>> = lines.iter().map(|line| line.clone().into_bytes()).collect();
    seeds.push(lines.join("\n").into_bytes());
    seeds
}

/// Commands to a session that stays. Those that make the simulation or the algorithms anew take long: most are read only, and one in an
/// input is obeyed.
pub fn commands(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let read = text.lines().filter_map(|line| serde_json::from_str::<Command>(line).ok());
    let commands: Vec<Command> = read.collect();
    if commands.is_empty() {
        return;
    }
    PLAYGROUND.with_borrow_mut(|session| {
        let mut is_made_anew = false;
        for command in commands {
            let is_obeyed = match command {
                Command::Algorithms { .. } | Command::Robots { .. } | Command::Likelihood { .. } => false,
                Command::Reset { .. } | Command::Parameter { .. } | Command::Defaults { .. } => {
                    !std::mem::replace(&mut is_made_anew, true)
                }
                _ => true,
            };
            if is_obeyed {
                let _ = session.handle(&command);
            }
            if let Some(secs) = session.step_secs() {
                assert!(secs >= 0.0 && secs.is_finite(), "{command:?}: {secs}");
            }
        }
    });
}

/// What somebody has drawn on a page, and a map file.
pub fn building_seeds() -> Vec<Vec<u8>> {
    let wall = |from: [f64; 2], to: [f64; 2]| json!({ "from": from, "to": to });
    let walls = [
        wall([0.0, 0.0], [8.0, 0.0]),
        wall([8.0, 0.0], [8.0, 2.0]),
        wall([8.0, 2.0], [0.0, 2.0]),
        wall([0.0, 2.0], [0.0, 0.0]),
    ];
    let doors = json!([{ "from": [1.0, 0.0], "to": [1.9, 0.0], "color": "red" }]);
    let drawn = json!({ "plan": { "kind": "office", "name": "drawn", "walls": walls, "doors": doors } });
    let text = visloc_world::BUILT_IN_MAPS[2].1;
    [drawn, json!({ "name": "office.toml", "text": text })].map(|asked| asked.to_string().into_bytes()).into()
}

pub fn building(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(answer) = answer_to(text) else { return };
    // What is drawn becomes a map file that is read again.
    if let Some(text) = answer["toml"].as_str().filter(|text| !text.is_empty()) {
        let again = answer_to(&json!({ "name": "again.toml", "text": text }).to_string()).unwrap();
        assert_eq!((&again["error"], &again["plan"]), (&json!(null), &answer["plan"]));
    }
}

fn message_of(kind: MessageKind, number: i32) -> Vec<u8> {
    let header = json!({
        "number": number, "secs": f64::from(number) * 0.1, "is_carried": false, "truth": { "pose": [0.0, 1.0, 0.5] },
        "contenders": [{ "name": "mc", "reliability": 0.5, "quality": 0.7, "error": [0.1, 0.2], "ms": [1.0, 2.0],
                         "is_localized": true }],
        "plots": [{ "name": "p", "series": ["a", "b"] }], "values": [[1.0, null]],
    });
    let mut builder = MessageBuilder::new(kind, &header).unwrap();
    builder.floats("dots", [1.0, 2.0, f64::NAN]);
    builder.bytes("image", &[1, 2, 3, 4, 5]);
    builder.finish()
}

pub fn message_seeds() -> Vec<Vec<u8>> {
    let kinds = [MessageKind::Scene, MessageKind::State, MessageKind::Image, MessageKind::Input];
    kinds.map(|kind| message_of(kind, 1)).into()
}

pub fn message(bytes: &[u8]) {
    let Ok(message) = Message::read(bytes) else { return };
    for name in message.names() {
        let _ = (message.floats(name), message.bytes(name));
    }
    let again = Message::read(&message.clone().write()).unwrap();
    assert_eq!(again.header, message.header);
}

fn record(num_frames: usize) -> Vec<u8> {
    in_folder(|folder| {
        let path = folder.join("seed-recording.mcap");
        let mut recorder = Recorder::create(&path).unwrap();
        let scene = message_of(MessageKind::Scene, 0).into();
        for i in 0..num_frames {
            let number = i32::try_from(i).unwrap();
            let update = Update {
                scene: std::sync::Arc::clone(&scene),
                state: message_of(MessageKind::State, number).into(),
                image: Some(message_of(MessageKind::Image, number).into()),
            };
            let frame = bags::frame(i);
            let input = Input::Robot { frame: &frame.frame, truth: frame.truth.as_ref() };
            recorder.add(&update, i as f64 * 0.1, Some(&input)).unwrap();
        }
        recorder.finish().unwrap();
        fs::read(path).unwrap()
    })
}

pub fn recording_seeds() -> Vec<Vec<u8>> {
    vec![record(1), record(3)]
}

/// Plays a recording to its end, there and back.
pub fn recording(bytes: &[u8]) {
    as_file("recording.mcap", bytes, |path| {
        let Ok(mut replay) = Replay::open(path, "recording-0", json!([])) else { return };
        let num_frames = replay.num_frames().min(20);
        for frame in (0..num_frames).chain([0]) {
            let _ = replay.handle(&Command::Seek { frame });
            let _ = replay.update(None);
            let _ = (replay.step_secs(), replay.step());
        }
        if let Ok(mut index) = visloc_studio::recording::RecordingIndex::open(path) {
            let _ = (0..num_frames).try_for_each(|frame| index.input(frame).map(drop));
        }
    });
}
