//! Writes a file and reads it back. Only with the feature `sdk`.
#![cfg(feature = "sdk")]
#![allow(missing_docs, clippy::unwrap_used)]

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::File,
    io::BufReader,
    path::Path,
    sync::Arc,
};

use re_log_encoding::DecoderApp;
use re_sdk::log::{Chunk, LogMsg};
use serde_json::{Value, json};
use visloc_rerun::RerunFile;
use visloc_studio::{MessageBuilder, MessageKind, Update};

const NUM_FRAMES: u32 = 5;

fn update(scene: &Arc<[u8]>, frame: u32) -> Update {
    let x = 0.1 * f64::from(frame);
    let contender = json!({
        "name": "Monte Carlo", "pose": [x, 0.0, 0.0], "reliability": 0.9, "is_localized": frame > 1,
        "hypotheses": [[x, 0.0, 0.0, 1.0]], "error": [0.1, 1.0], "quality": 0.5, "ms": { "image": 1.0, "pose": 0.5 },
    });
    let truth = json!({ "pose": [x, 0.0, 0.0], "height_m": 0.0 });
    let state = json!({ "truth": truth, "camera": [0.0, 0.8], "contenders": [contender] });
    let mut state = MessageBuilder::new(MessageKind::State, &state).unwrap();
    state.floats("individuals0", [x, 0.0, 0.0, 0.5, 0.0]);
    let header = json!({ "number": frame, "size_px": [320, 240], "horizon": [9.0, 9.0] });
    let mut image = MessageBuilder::new(MessageKind::Image, &header).unwrap();
    image.bytes("jpeg", &[0xff, 0xd8, 0xff, 0xd9]);
    image.floats("kept", [1.0, 2.0, 0.0]);
    Update { scene: Arc::clone(scene), state: state.finish().into(), image: Some(image.finish().into()) }
}

fn scene(header: &Value) -> Arc<[u8]> {
    MessageBuilder::new(MessageKind::Scene, header).unwrap().finish().into()
}

/// Rows and time lines of each entity of the recording, and whether a layout is activated.
fn read(path: &Path) -> (BTreeMap<String, (usize, BTreeSet<String>)>, bool) {
    let (mut entities, mut has_layout) = (BTreeMap::new(), false);
    for message in DecoderApp::decode_eager(BufReader::new(File::open(path).unwrap())).unwrap() {
        match message.unwrap() {
            LogMsg::ArrowMsg(store, message) if store.is_recording() => {
                let chunk = Chunk::from_arrow_msg(&message).unwrap();
                let entity: &mut (usize, BTreeSet<String>) =
                    entities.entry(chunk.entity_path().to_string()).or_default();
                entity.0 += chunk.num_rows();
                entity.1.extend(chunk.timelines().keys().map(ToString::to_string));
            }
            LogMsg::BlueprintActivationCommand(command) => has_layout = command.make_active,
            _ => {}
        }
    }
    (entities, has_layout)
}

#[test]
fn a_file_holds_every_frame_on_both_time_lines_and_a_layout() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/run.rrd");
    let world = json!({
        "kind": "field", "bounds_m": [-3.7, -2.7, 3.7, 2.7], "line_width_m": 0.05, "circle_radius_m": 0.6,
        "lines": [[-3.0, -2.0, 3.0, -2.0]], "marks": [], "goals": [],
    });
    let scene = scene(&json!({ "title": "Tour", "world": world, "drop_reasons": ["small"] }));
    let mut file = RerunFile::create(&path).unwrap();
    for frame in 0..NUM_FRAMES {
        file.add(&update(&scene, frame), 0.1 * f64::from(frame)).unwrap();
    }
    file.finish().unwrap();
    let (entities, has_layout) = read(&path);
    assert!(has_layout);
    let both = BTreeSet::from(["frame".to_owned(), "time".to_owned()]);
    let num_frames = NUM_FRAMES as usize;
    for (entity, num_rows) in [
        ("/camera/image/kept", num_frames),
        ("/world/monte-carlo/pose", num_frames),
        ("/world/monte-carlo/particles", num_frames),
        ("/world/truth/way", num_frames - 1),
        ("/events", 1),
        ("/numbers", num_frames),
    ] {
        assert_eq!(entities[entity], (num_rows, both.clone()), "{entity}");
    }
    for entity in ["/world", "/world/map/ground", "/world/map/lines"] {
        assert_eq!(entities[entity], (1, BTreeSet::new()), "{entity}");
    }
    // Image and curves have their names and colors at the same place, for the whole recording.
    for entity in ["/camera/image", "/plots/position-error"] {
        assert_eq!(entities[entity], (num_frames + 1, both.clone()), "{entity}");
    }
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("taken"), "").unwrap();
    let error = RerunFile::create(&folder.path().join("taken/run.rrd")).err().unwrap().to_string();
    assert!(error.contains("taken"), "{error}");
}
