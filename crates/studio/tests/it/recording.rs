//! Recordings, whole and damaged.

use std::{fs, path::Path};

use serde_json::json;
use visloc_studio::{
    Message, Session,
    recording::{Recorder, RecordingIndex, Replay},
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
        recorder.add(&update, i as f64 / 30.0).unwrap();
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
    assert_eq!(messages.len(), 1 + 2 * 5);
    let last = messages.last().unwrap();
    assert_eq!((last.channel.topic.as_str(), last.data.as_ref()), ("/studio/state", states[4].as_slice()));
    assert_eq!(last.log_time, 133_333_333);
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
