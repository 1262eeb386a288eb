//! A robot with two cameras in a bag.
#![allow(clippy::unwrap_used)]

use visloc_core::{
    Frame, Host, RgbImage, SourceFrame, Timestamp,
    geom::{Camera, Mount, PlanarPose},
};
use visloc_io::{
    bag::{BagReader, BagTopics, BagWriter},
    sources::{SourceOptions, TopicOptions, open_frames, open_images},
};

const UPPER: &str = "/camera/image/compressed";
const LOWER: &str = "/camera_2/image/compressed";

/// What camera `index` sees at moment `i`: the second takes every other image.
fn frame(i: u32, index: usize) -> SourceFrame {
    let focal_px = if index == 0 { 30.0 } else { 40.0 };
    let mount = Mount { height_m: 0.5, tilt_rad: if index == 0 { 0.1 } else { 0.8 }, ..Mount::default() };
    let at = Timestamp::from_secs(100.0 + 0.1 * f64::from(i));
    let camera = Camera::pinhole((16, 12), (focal_px, focal_px), (7.5, 5.5)).unwrap();
    let frame = Frame::new(at, RgbImage::new(16, 12), camera, mount.robot_from_camera()).of_camera(index);
    let odometry = Some(PlanarPose::new(0.1 * f64::from(i), 0.0, 0.0));
    SourceFrame { frame: Frame { odometry, ..frame }, truth: None }
}

#[test]
fn a_bag_of_two_cameras_comes_back_in_order_and_one_of_them_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.mcap");
    let mut written = Vec::new();
    for i in 0..6 {
        written.push(frame(i, 0));
        if i % 2 == 0 {
            written.push(frame(i, 1));
        }
    }
    let mut writer = BagWriter::create(&path, BagTopics::default()).unwrap();
    written.iter().for_each(|frame| writer.write(frame).unwrap());
    writer.finish().unwrap();
    let reader = BagReader::open(&path, BagTopics::default()).unwrap();
    let num_odometry =
        reader.available_topics().iter().find(|info| info.topic == "/odom").unwrap().num_messages;
    assert_eq!(num_odometry, 6, "once for each moment");

    let topics = |more: &[&str]| TopicOptions {
        image: Some(UPPER.into()),
        more_images: more.iter().map(|topic| (*topic).to_owned()).collect(),
        ..TopicOptions::default()
    };
    let bag = path.display().to_string();
    let open = |options: &SourceOptions| open_frames(&bag, options, &Host::silent());
    let both = SourceOptions { topics: topics(&[LOWER]), ..SourceOptions::default() };
    let mut frames = open(&both).unwrap().frames;
    assert_eq!(frames.status().num_items, Some(9));
    for SourceFrame { frame: expected, .. } in &written {
        let found = frames.next_item().unwrap().unwrap().frame;
        assert_eq!((found.at, found.camera_index), (expected.at, expected.camera_index));
        assert_eq!(found.camera, expected.camera);
        let off = found.robot_from_camera.rotation() - expected.robot_from_camera.rotation();
        assert!(off.norm() < 1e-9);
        assert_eq!(found.odometry, expected.odometry);
    }
    assert!(frames.next_item().is_none() && frames.status().skipped.is_empty());

    let one = SourceOptions { topics: topics(&[]), ..SourceOptions::default() };
    assert_eq!(open(&one).unwrap().frames.status().num_items, Some(6));
    let refused = |options: &SourceOptions| open(options).err().unwrap().to_string();
    let twice = SourceOptions { topics: topics(&[UPPER]), ..SourceOptions::default() };
    assert!(refused(&twice).contains("twice"), "{}", refused(&twice));
    let mounted = SourceOptions { mount: Some(Mount::default()), ..both.clone() };
    assert!(refused(&mounted).contains("--camera-height is of one camera"), "{}", refused(&mounted));
    let missing = SourceOptions { topics: topics(&["/mouth/image"]), ..SourceOptions::default() };
    assert!(refused(&missing).contains("/mouth/image"), "{}", refused(&missing));
    let error = open_images(&bag, &both, &Host::silent()).err().unwrap().to_string();
    assert!(error.contains("--image-topic") && error.contains("one camera"), "{error}");
}
