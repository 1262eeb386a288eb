//! SLAM in the studio.

use std::{path::Path, sync::Arc};

use serde_json::json;
use visloc_core::{Clock, ImageSource, Source};
use visloc_sim::CameraTour;
use visloc_slam::{Slam, SlamConfig};
use visloc_studio::{
    Message, Scenes, Session, StudioError,
    recording::{Recorder, RecordingIndex},
    replay::Replay,
    slam::{Job, OpenCamera, SequenceSource, SlamSession},
};
use visloc_vmap::VisualMap;

use crate::support::{command_of, scene, state, steps, tell};

#[test]
fn a_tour_makes_a_map_that_is_shown_in_the_frame_of_the_truth() {
    let from = SequenceSource::Tour("room".to_owned());
    let mut session =
        SlamSession::open(from, Job::Teach(None), json!({ "scene": "sim:room" }), Clock::still(), 1).unwrap();
    steps(&mut session, 50);
    let update = session.update(None).unwrap();
    assert_eq!(scene(&update)["world"]["kind"], "space");
    let message = Message::read(&update.state).unwrap();
    assert!(message.floats("landmarks").unwrap().len() > 3 * 100);
    assert_eq!(message.floats("keyframes").unwrap().len() % 12, 0);
    let error_m = message.header["values"][0][0].as_f64().unwrap();
    assert!(error_m < 0.1, "{error_m} m");
    let image = Message::read(&update.image.unwrap()).unwrap();
    assert!(image.floats("landmarks").unwrap().len() > 2 * 20 && image.floats("missed").is_some());
    assert!(state(&mut session)["facts"].as_array().unwrap().len() > 8);
}

/// Arrays of a state message that tell where camera and map are.
const SHOWN: [&str; 6] = ["landmarks", "candidates", "keyframes", "links", "trajectory", "camera"];

fn record(path: &Path, num_frames: usize, seed: u64) {
    let from = SequenceSource::Tour("room".to_owned());
    let mut session =
        SlamSession::open(from, Job::Teach(None), json!({ "scene": "sim:room" }), Clock::still(), seed)
            .unwrap();
    tell(&mut session, json!({ "type": "parameter", "path": "tracking.max_matches", "value": 130 }));
    let mut recorder = Recorder::create(path).unwrap();
    for frame in 0..num_frames {
        let update = session.update(None).unwrap();
        recorder.add(&update, frame as f64 / 30.0, session.input().as_ref()).unwrap();
        steps(&mut session, 1);
    }
    recorder.finish().unwrap();
}

fn recompute(replay: &mut Replay, seed: u64) {
    tell(replay, json!({ "type": "recompute", "seed": seed }));
    while state(replay)["recomputing"].is_object() {
        steps(replay, 1);
    }
}

/// State and image of a frame.
fn shown(replay: &mut Replay, frame: usize) -> (Message, Message) {
    tell(replay, json!({ "type": "seek", "frame": frame }));
    let update = replay.update(None).unwrap();
    (Message::read(&update.state).unwrap(), Message::read(&update.image.unwrap()).unwrap())
}

#[test]
fn a_recording_gives_the_same_map_again_with_the_same_settings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.mcap");
    record(&path, 60, 3);
    let mut replay = Replay::open(&path, "recording-0", json!([])).unwrap();
    assert_eq!(scene(&replay.update(None).unwrap())["recording"]["can_recompute"], json!(true));
    let recorded: Vec<_> = (0..60).map(|frame| shown(&mut replay, frame)).collect();
    recompute(&mut replay, 3);
    for (frame, (state_before, image_before)) in recorded.iter().enumerate() {
        let (state, image) = shown(&mut replay, frame);
        for name in SHOWN {
            assert_eq!(state.floats(name), state_before.floats(name), "{name} of frame {frame}");
        }
        assert_eq!(state.floats("recorded"), state_before.floats("trajectory"));
        assert_eq!(image.bytes("jpeg"), image_before.bytes("jpeg"));
        assert_eq!(image.floats("missed"), image_before.floats("missed"));
        let error = &state.header["values"][0];
        assert_eq!(error[0], error[1], "the error of frame {frame}");
    }
    assert!(recorded[59].0.floats("landmarks").unwrap().len() > 3 * 100);
    assert!(recorded[59].0.header["values"][0][0].as_f64().unwrap() < 0.1);
    let scene = scene(&replay.update(None).unwrap());
    assert_eq!(scene["plots"][0]["series"], json!(["error", "error, again"]));
    assert_eq!(
        (&scene["seed"], &scene["pipeline"]["changed"]),
        (&json!(3), &json!(["tracking.max_matches"]))
    );
}

/// Most of what the studio adds to the input, a frame, bytes.
const MAX_ADDED: u64 = 40_000;

#[test]
fn a_recording_holds_the_map_and_the_picture_of_a_moment_once_and_shows_them_always() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.mcap");
    record(&path, 120, 3);
    let bytes = std::fs::read(&path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let is_input = |topic: &str| topic == "/camera/image/compressed";
    let added: u64 = messages.filter(|m| !is_input(&m.channel.topic)).map(|m| m.data.len() as u64).sum();
    assert!(added / 120 < MAX_ADDED, "{} bytes a frame", added / 120);
    let mut index = RecordingIndex::open(&path).unwrap();
    for frame in [40, 60, 71, 119] {
        let state = index.state(frame).unwrap();
        assert!(SHOWN.iter().all(|name| state.floats(name).is_some()), "frame {frame}");
        assert!(!state.header.contains_key("map_moment"));
        let image = Message::read(&index.image(frame).unwrap().unwrap()).unwrap();
        assert_eq!(image.bytes("jpeg").unwrap()[..2], [0xff, 0xd8], "a JPEG at frame {frame}");
    }
    assert!(index.state(119).unwrap().floats("landmarks").unwrap().len() > 3 * 500);
}

#[test]
fn a_recording_is_computed_with_another_preset_and_as_recorded_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.mcap");
    record(&path, 40, 1);
    let mut replay = Replay::open(&path, "recording-0", json!([])).unwrap();
    let before = shown(&mut replay, 39).0.floats("landmarks");
    tell(&mut replay, json!({ "type": "algorithms", "names": ["orb-sdvl"] }));
    recompute(&mut replay, 1);
    let (other, _) = shown(&mut replay, 39);
    assert_ne!(other.floats("landmarks"), before);
    assert_eq!(scene(&replay.update(None).unwrap())["preset"], json!("orb-sdvl"));
    tell(&mut replay, json!({ "type": "recorded" }));
    let (back, _) = shown(&mut replay, 39);
    assert_eq!((back.floats("landmarks"), back.floats("recorded")), (before, None));
    assert_eq!(back.header["values"][0].as_array().unwrap().len(), 1);
    assert!(replay.handle(&command_of(json!({ "type": "algorithms", "names": ["moon"] }))).is_err());
}

#[test]
fn an_unknown_sequence_is_refused() {
    let open = |from| {
        SlamSession::open(from, Job::Teach(None), json!({}), Clock::still(), 1).err().unwrap().to_string()
    };
    assert!(open(SequenceSource::Tour("moon".to_owned())).contains("room"));
    let nowhere = |_| Err(StudioError::input("/nowhere", "not there"));
    let other = SequenceSource::Other("/nowhere".to_owned(), Arc::new(nowhere), false);
    assert!(open(other).contains("/nowhere"));
}

fn room() -> SlamSession {
    let from = SequenceSource::Tour("room".to_owned());
    SlamSession::open(from, Job::Teach(None), json!({ "scene": "sim:room" }), Clock::still(), 1).unwrap()
}

/// Frames within which a kidnapped camera finds itself, ten seconds.
const MAX_LOST_FRAMES: usize = 300;

#[test]
fn a_covered_camera_is_lost_and_a_kidnapped_one_finds_itself_again() {
    let mut session = room();
    steps(&mut session, 90);
    assert_eq!(state(&mut session)["is_lost"], json!(false));
    tell(&mut session, json!({ "type": "cover", "is_on": true }));
    steps(&mut session, 5);
    assert_eq!(state(&mut session)["is_lost"], json!(true));
    assert_eq!(state(&mut session)["controls"]["is_covered"], json!(true));
    tell(&mut session, json!({ "type": "kidnap" }));
    tell(&mut session, json!({ "type": "cover", "is_on": false }));
    assert_eq!(state(&mut session)["controls"]["is_held"], json!(true));
    // It is carried to where it has been; the way leads past views that the map knows.
    for _ in 0..MAX_LOST_FRAMES {
        steps(&mut session, 1);
        if state(&mut session)["is_lost"] == json!(false) {
            break;
        }
    }
    let state = state(&mut session);
    assert_eq!((&state["is_lost"], &state["controls"]["is_held"]), (&json!(false), &json!(false)));
    let error_m = state["values"][0][0].as_f64().unwrap();
    assert!(error_m < 0.15, "{error_m} m: it is where the truth is after the kidnap");
}

#[test]
fn presets_and_parameters_start_it_anew() {
    let mut session = room();
    steps(&mut session, 10);
    let names = |session: &mut SlamSession| scene(&session.update(None).unwrap());
    assert_eq!(names(&mut session)["preset"], json!("sdvl"));
    tell(&mut session, json!({ "type": "algorithms", "names": ["orb-sdvl"] }));
    assert_eq!(
        (&names(&mut session)["preset"], &state(&mut session)["number"]),
        (&json!("orb-sdvl"), &json!(0))
    );
    let change = json!({ "type": "parameter", "path": "tracking.max_matches", "value": 111 });
    tell(&mut session, change);
    assert_eq!(names(&mut session)["pipeline"]["changed"], json!(["tracking.max_matches"]));
    for wrong in [
        json!({ "type": "parameter", "path": "tracking.max_matches", "value": -1 }),
        json!({ "type": "parameter", "path": "no.such", "value": 1 }),
        json!({ "type": "algorithms", "names": ["moon"] }),
        json!({ "type": "walk_to", "x_m": 0, "y_m": 0 }),
    ] {
        assert!(session.handle(&command_of(wrong.clone())).is_err(), "{wrong}");
    }
    assert_eq!(names(&mut session)["pipeline"]["changed"], json!(["tracking.max_matches"]), "as it was");
}

#[test]
fn images_of_any_source_are_followed_to_their_end() {
    let open = |seed| {
        let tour = CameraTour::new("room", seed).unwrap().with_size((160, 120)).unwrap().with_frames(0, 8, 1);
        Ok(OpenCamera { truth: Some(tour.truth()), images: Box::new(tour) })
    };
    let from = SequenceSource::Other("any".to_owned(), Arc::new(open), false);
    let mut session = SlamSession::open(from, Job::Teach(None), json!({}), Clock::still(), 1).unwrap();
    while session.step_secs().is_some() {
        session.step().unwrap();
        std::thread::yield_now();
    }
    assert_eq!(
        (&state(&mut session)["number"], &state(&mut session)["is_playing"]),
        (&json!(7), &json!(false))
    );
    assert!(scene(&session.update(None).unwrap())["has_hands"] == json!(false));
    assert!(session.handle(&command_of(json!({ "type": "kidnap" }))).is_err());
}

/// A map of the beginning of a tour, in the frame of the truth.
fn taught() -> Arc<VisualMap> {
    let mut tour = CameraTour::new("room", 1).unwrap().with_frames(0, 120, 2);
    let mut slam = Slam::new(tour.camera(), &SlamConfig::default(), 1).unwrap();
    while let Some(frame) = tour.next_item() {
        let frame = frame.unwrap();
        slam.add_frame(frame.at, frame.image).unwrap();
    }
    let mut map = VisualMap::default().after(&slam, Default::default());
    let largest = map.largest().unwrap();
    map.align(largest, &tour.truth()).unwrap();
    Arc::new(map)
}

#[test]
fn a_camera_is_found_in_the_map_of_an_earlier_session_also_after_a_kidnap() {
    let from = SequenceSource::Tour("room".to_owned());
    let more = json!({ "scene": "source-0" });
    let mut session = SlamSession::open(from, Job::Find(taught()), more, Clock::still(), 5).unwrap();
    steps(&mut session, 20);
    let update = session.update(None).unwrap();
    assert_eq!(scene(&update)["plots"][1]["title"], json!("Reliability"));
    let message = Message::read(&update.state).unwrap();
    assert_eq!(message.header["is_lost"], json!(false));
    let error_m = message.header["values"][0][0].as_f64().unwrap();
    assert!(error_m < 0.05, "{error_m} m from the truth, in the frame of the map");
    assert!(message.header["values"][1][0].as_f64().unwrap() > 0.6);
    assert!(message.header["values"][2][2].as_f64().unwrap() > 20.0, "landmarks of the map");
    for name in ["landmarks", "keyframes", "trajectory", "truth", "camera"] {
        assert!(message.floats(name).unwrap().len() >= 12, "{name}");
    }
    tell(&mut session, json!({ "type": "cover", "is_on": true }));
    steps(&mut session, 4);
    let lost = state(&mut session);
    assert_eq!((&lost["is_lost"], &lost["values"][1][0]), (&json!(true), &json!(0.0)));
    tell(&mut session, json!({ "type": "cover", "is_on": false }));
    steps(&mut session, 6);
    let message = Message::read(&session.update(None).unwrap().state).unwrap();
    assert_eq!(message.header["is_lost"], json!(false));
    assert!(
        message.floats("trajectory").unwrap().iter().any(|value| value.is_nan()),
        "the way was interrupted"
    );
}

#[test]
fn a_recording_of_a_camera_in_a_map_is_replayed_but_not_computed_without_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in-map.mcap");
    let from = SequenceSource::Tour("room".to_owned());
    let mut session =
        SlamSession::open(from, Job::Find(taught()), json!({ "scene": "source-0" }), Clock::still(), 1)
            .unwrap();
    let mut recorder = Recorder::create(&path).unwrap();
    for frame in 0..5 {
        let update = session.update(None).unwrap();
        recorder.add(&update, f64::from(frame) / 30.0, session.input().as_ref()).unwrap();
        steps(&mut session, 1);
    }
    recorder.finish().unwrap();
    let mut replay = Replay::open(&path, "recording-0", json!([])).unwrap();
    assert_eq!(scene(&replay.update(None).unwrap())["recording"]["can_recompute"], json!(false));
    let (state, _) = shown(&mut replay, 4);
    assert!(state.header["values"][1][0].as_f64().unwrap() > 0.6);
}

#[test]
fn a_room_is_taught_at_the_page_and_the_camera_found_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = Scenes::new(Clock::still(), Clock::still(), 1).with_folder(folder.path().to_path_buf());
    let mut session = scenes.open("sim:room").unwrap();
    let save = || command_of(json!({ "type": "save" }));
    let early = session.handle(&save()).unwrap_err().to_string();
    assert!(early.contains("found none yet"), "{early}");
    steps(&mut *session, 90);
    session.handle(&save()).unwrap();
    let taught = state(&mut *session)["taught"].clone();
    assert!(taught["num_keyframes"].as_u64().unwrap() > 3 && taught["num_landmarks"].as_u64().unwrap() > 100);
    let file = folder.path().join("room-001.vmap");
    assert_eq!(taught["file"], json!(file));
    assert_eq!(visloc_vmap::load(&file).unwrap().map.sessions[0].num_images, 91);

    let mut session = scenes.open("taught-0").unwrap();
    assert_eq!(scene(&session.update(None).unwrap())["does"], json!("find"));
    steps(&mut *session, 20);
    let found = state(&mut *session);
    assert_eq!(found["is_lost"], json!(false));
    let error_m = found["values"][0][0].as_f64().unwrap();
    assert!(error_m < 0.1, "{error_m} m from the truth");
    let refused = session.handle(&save()).unwrap_err().to_string();
    assert!(refused.contains("stays as it is"), "{refused}");

    // Who goes on in it adds to what was known.
    let mut session = scenes.open("teach-0").unwrap();
    steps(&mut *session, 150);
    session.handle(&save()).unwrap();
    let more = state(&mut *session)["taught"].clone();
    assert_eq!(more["file"], json!(folder.path().join("room-002.vmap")));
    assert!(more["num_keyframes"].as_u64() > taught["num_keyframes"].as_u64(), "{more} after {taught}");
    assert!(scenes.open("taught-2").is_err());
}
