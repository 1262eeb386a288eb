//! Recordings, whole and damaged.

use std::{fs, path::Path};

use serde_json::{Value, json};
use visloc_core::{Clock, Source as _};
use visloc_io::bag::{BagReader, BagTopics};
use visloc_studio::{
    Message, Session,
    recording::{Recorder, RecordingIndex, Tape},
    replay::Replay,
};

use crate::support::{playground, scene, state, steps, tell};

/// Records a robot that is kidnapped.
fn record(path: &Path, num_frames: usize) -> Vec<Vec<u8>> {
    let mut session = playground("robocup-2010", 1);
    let mut recorder = Recorder::create(path).unwrap();
    let mut states = Vec::new();
    for i in 0..num_frames {
        if i == 60 {
            tell(&mut session, json!({ "type": "kidnap", "x_m": -1.5, "y_m": 1.0 }));
        }
        let update = session.update(None).unwrap();
        recorder.add(&update, i as f64 / 30.0, session.input().as_ref()).unwrap();
        states.push(update.state.to_vec());
        steps(&mut session, 1);
    }
    recorder.finish().unwrap();
    states
}

#[test]
fn what_was_recorded_is_replayed_in_any_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let states = record(&path, 20);
    let mut index = RecordingIndex::open(&path).unwrap();
    assert_eq!(index.num_frames(), 20);
    for frame in [13, 2, 19, 0] {
        assert_eq!(index.state(frame).unwrap(), Message::read(&states[frame]).unwrap());
        let image = Message::read(&index.image(frame).unwrap().unwrap()).unwrap();
        assert_eq!(image.header["number"], json!(frame));
    }
    assert!(index.has_same_scene(0, 19));
}

#[test]
fn other_tools_can_read_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let states = record(&path, 5);
    let bytes = fs::read(&path).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let last = messages.last().unwrap();
    assert_eq!(last.channel.topic.as_str(), "/studio/state");
    assert_eq!(Message::read(&last.data).unwrap(), Message::read(&states[4]).unwrap());
    let count = |topic: &str| messages.iter().filter(|message| message.channel.topic == topic).count();
    assert_eq!((count("/studio/scene"), count("/studio/image"), count("/studio/state")), (1, 5, 5));
    let mut bag = BagReader::open(&path, BagTopics::default()).unwrap();
    let mut frames = 0;
    while let Some(frame) = bag.next_item() {
        let frame = frame.unwrap();
        assert!(frame.frame.odometry.is_some() && frame.truth.is_some());
        frames += 1;
    }
    assert_eq!(frames, 5, "it is a bag as well");
}

#[test]
fn a_replay_is_stepped_and_scrubbed_and_tells_what_happened() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 240);
    let mut replay = Replay::open(&path, "recording-0", json!([])).unwrap();
    assert_eq!(replay.num_frames(), 240);
    let scene = scene(&replay.update(None).unwrap());
    let kinds: Vec<&str> = scene["recording"]["annotations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|annotation| annotation["kind"].as_str().unwrap())
        .collect();
    assert!(kinds.contains(&"kidnap") && kinds.contains(&"found"), "{kinds:?}");
    tell(&mut replay, json!({ "type": "seek", "frame": 100 }));
    assert!(replay.step_secs().is_none(), "it rests where it was put");
    assert_eq!(state(&mut replay)["number"], json!(100));
    tell(&mut replay, json!({ "type": "step" }));
    assert_eq!(state(&mut replay)["number"], json!(101));
    tell(&mut replay, json!({ "type": "seek", "frame": 100_000 }));
    assert_eq!(state(&mut replay)["number"], json!(239));
    tell(&mut replay, json!({ "type": "play" }));
    assert!((replay.step_secs().unwrap() - 1.0 / 30.0).abs() < 1e-3);
    assert_eq!(state(&mut replay)["number"], json!(0), "from the end it begins again");
}

#[test]
fn a_cut_recording_is_good_up_to_the_cut() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 12);
    let bytes = fs::read(&path).unwrap();
    let mut last = 0;
    for share in 1..=10 {
        fs::write(&path, &bytes[..bytes.len() * share / 10]).unwrap();
        let num_frames = RecordingIndex::open(&path).map_or(0, |mut index| {
            index.state(index.num_frames() - 1).unwrap();
            index.num_frames()
        });
        assert!(num_frames >= last && num_frames <= 12);
        last = num_frames;
    }
    assert_eq!(last, 12);
}

#[test]
fn what_is_no_recording_is_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other");
    let mut damaged = vec![0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
    damaged.extend([0x05; 400]);
    for bytes in [&b""[..], b"not a recording at all", &damaged] {
        fs::write(&path, bytes).unwrap();
        let error = RecordingIndex::open(&path).unwrap_err().to_string();
        assert!(error.contains("expected a recording of visloc"), "{error}");
    }
    assert!(RecordingIndex::open(&folder.path().join("missing")).is_err());
}

/// Replays a recording that is computed again; the replay and its scratch folder.
fn recomputed(path: &Path, seed: u64, changes: &[Value]) -> Replay {
    let mut replay = Replay::open(path, "recording-0", json!([])).unwrap().with_scratch(
        path.parent().unwrap(),
        Clock::still(),
        Clock::still(),
    );
    changes.iter().for_each(|change| tell(&mut replay, change.clone()));
    tell(&mut replay, json!({ "type": "recompute", "seed": seed }));
    while state(&mut replay)["recomputing"].is_object() {
        assert_eq!(replay.step_secs(), Some(0.0));
        steps(&mut replay, 1);
    }
    replay
}

/// What an algorithm estimated at a frame, without its name.
fn estimate(replay: &mut Replay, frame: usize, lane: usize) -> Value {
    tell(replay, json!({ "type": "seek", "frame": frame }));
    let mut contender = state(replay)["contenders"][lane].clone();
    contender.as_object_mut().unwrap().remove("name");
    contender
}

#[test]
fn the_same_input_and_parameters_give_the_same_estimates_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 90);
    let mut replay = recomputed(&path, 1, &[]);
    for frame in 0..90 {
        for lane in 0..2 {
            let (recorded, again) =
                (estimate(&mut replay, frame, lane), estimate(&mut replay, frame, lane + 2));
            assert_eq!(recorded, again, "frame {frame}, algorithm {lane}");
        }
        let message = Message::read(&replay.update(None).unwrap().state).unwrap();
        assert_eq!(message.floats("individuals0"), message.floats("individuals2"));
    }
    let names = &scene(&replay.update(None).unwrap())["recording"]["lanes"];
    assert_eq!(*names, json!(["evolutionary", "mce", "evolutionary, again", "mce, again"]));
    tell(&mut replay, json!({ "type": "recorded" }));
    assert_eq!(state(&mut replay)["contenders"].as_array().unwrap().len(), 2, "back to what was recorded");
    drop(replay);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
}

#[test]
fn other_parameters_seeds_and_algorithms_give_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 40);
    let change = json!({ "type": "parameter", "algorithm": 1, "path": "num_particles", "value": 77 });
    let mut replay = recomputed(&path, 1, &[json!({ "type": "algorithms", "names": ["mce", "mc"] }), change]);
    assert_eq!(estimate(&mut replay, 39, 3)["num_individuals"], json!(77));
    assert_eq!(scene(&replay.update(None).unwrap())["contenders"][1]["changed"], json!(["num_particles"]));
    let mut replay = recomputed(&path, 5, &[]);
    assert_ne!(estimate(&mut replay, 5, 0), estimate(&mut replay, 5, 2));
    let wrong = json!({ "type": "parameter", "algorithm": 0, "path": "num_particles", "value": -3 });
    assert!(replay.handle(&crate::support::command_of(wrong)).is_err());
}

#[test]
fn what_holds_no_input_cannot_be_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut session = playground("robocup-2010", 1);
    let mut recorder = Recorder::create(&path).unwrap();
    recorder.add(&session.update(None).unwrap(), 0.0, None).unwrap();
    recorder.finish().unwrap();
    let mut replay = Replay::open(&path, "recording-0", json!([])).unwrap();
    assert_eq!(scene(&replay.update(None).unwrap())["recording"]["can_recompute"], json!(false));
    let error = replay.handle(&crate::support::command_of(json!({ "type": "recompute", "seed": 1 })));
    assert!(error.unwrap_err().to_string().contains("expected a recording with its input"));
}

#[test]
fn pages_choose_no_names_and_a_moment_is_recorded_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut session = playground("robocup-2010", 1);
    let mut tape = Tape::new(&folder.path().join("recordings"));
    let mut names = Vec::new();
    for _ in 0..2 {
        tape.start("../../etc/passwd").unwrap();
        for _ in 0..3 {
            let update = session.update(None).unwrap();
            for _ in 0..2 {
                assert_eq!(tape.offer(&update, session.input().as_ref()).unwrap(), None);
            }
            steps(&mut session, 1);
        }
        assert_eq!(tape.status().unwrap()["num_frames"], json!(3));
        let path = tape.stop().unwrap().unwrap();
        assert_eq!(RecordingIndex::open(&path).unwrap().num_frames(), 3);
        names.push(path.strip_prefix(folder.path()).unwrap().display().to_string());
    }
    assert_eq!(names, ["recordings/------etc-passwd-001.mcap", "recordings/------etc-passwd-002.mcap"]);
    assert_eq!(tape.stop().unwrap(), None);
    tape.start("again").unwrap();
    tape.offer(&session.update(None).unwrap(), None).unwrap();
    tell(&mut session, json!({ "type": "reset", "seed": 2 }));
    let ended = tape.offer(&session.update(None).unwrap(), None).unwrap();
    assert!(ended.is_some(), "a new start ends a recording");
}
