//! SLAM in the studio.

use serde_json::json;
use visloc_slam::Clock;
use visloc_studio::{
    Message, Session,
    slam::{SequenceSource, SlamSession},
};

use crate::support::{scene, state, steps};

#[test]
fn a_tour_makes_a_map_that_is_shown_in_the_frame_of_the_truth() {
    let from = SequenceSource::Tour("room".to_owned());
    let mut session = SlamSession::open(from, json!({ "scene": "sim:room" }), Clock::none(), 1).unwrap();
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

#[test]
fn an_unknown_sequence_is_refused() {
    let open = |from| SlamSession::open(from, json!({}), Clock::none(), 1).err().unwrap().to_string();
    assert!(open(SequenceSource::Tour("moon".to_owned())).contains("room"));
    assert!(open(SequenceSource::Folder("/nowhere".into())).contains("/nowhere"));
}
