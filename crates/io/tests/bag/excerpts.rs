//! Recordings that another program wrote.

use visloc_core::{GroundContact, Source};
use visloc_io::bag::{BagError, BagReader, BagTopics};

use crate::support::{read, testdata};

#[test]
fn counts_sizes_and_contact() {
    for (name, num_frames) in [("R1-excerpt.mcap", 90), ("R2-excerpt.mcap", 135)] {
        let bag = BagReader::open(testdata(name), BagTopics::default()).unwrap();
        assert_eq!((bag.status().num_items, bag.available_topics().len()), (Some(num_frames), 6));
        let back = read(&testdata(name));
        assert!(back.error.is_none() && back.skipped.is_empty());
        assert_eq!(back.frames.len(), num_frames);
        for source_frame in &back.frames {
            let frame = &source_frame.frame;
            assert_eq!((frame.image.width(), frame.image.height()), (320, 240));
            assert_eq!(frame.camera.size_px(), (320, 240));
            assert!(frame.odometry.unwrap().is_finite());
            let height_m = source_frame.truth.unwrap().height_m;
            // near the ground the lifted robot has lost contact before it is high
            if height_m > 0.01 {
                assert_eq!(frame.ground_contact, Some(GroundContact::Contact(false)));
            }
        }
    }
    let lifted = read(&testdata("R2-excerpt.mcap"));
    let num_lifted = lifted
        .frames
        .iter()
        .filter(|frame| frame.frame.ground_contact == Some(GroundContact::Contact(false)))
        .count();
    assert_eq!(num_lifted, 20);
}

/// True camera positions from the table that the renderer wrote beside the full recording R1, frames 0, 30 and 87
/// of the excerpt, meters.
const TRUE_CAMERAS: [(usize, [f64; 3]); 3] = [
    (0, [-1.482837, 1.049685, 0.463986]),
    (30, [-1.47578, 1.02235, 0.460949]),
    (87, [-0.561859, 1.277607, 0.45992]),
];

#[test]
fn truth_and_kinematics_give_the_true_camera() {
    let back = read(&testdata("R1-excerpt.mcap"));
    for (index, expected_m) in TRUE_CAMERAS {
        let source_frame = &back.frames[index];
        let world_from_robot = source_frame.truth.unwrap().world_from_robot.to_rigid3();
        let found_m = (world_from_robot * source_frame.frame.robot_from_camera).translation().to_owned();
        // the kinematics of the recording have noise of 2 mm and a bias
        assert!((found_m - nalgebra::Vector3::from(expected_m)).norm() < 0.02, "frame {index}: {found_m:?}");
    }
}

#[test]
fn missing_topics_are_named_with_those_that_are_there() {
    let topics = BagTopics { image: "/camera/image_raw".into(), ..BagTopics::default() };
    let Err(error) = BagReader::open(testdata("R1-excerpt.mcap"), topics) else { panic!("opened") };
    assert!(matches!(error, BagError::MissingTopic { .. }));
    let text = error.to_string();
    for part in ["/camera/image_raw", "/camera/image/compressed (sensor_msgs/msg/CompressedImage)", "/odom"] {
        assert!(text.contains(part), "{text}");
    }
    let topics = BagTopics { odometry: "/wheels".into(), ..BagTopics::default() };
    assert!(BagReader::open(testdata("R1-excerpt.mcap"), topics).is_err());
    let topics = BagTopics { odometry: String::new(), ..BagTopics::default() };
    let mut bag = BagReader::open(testdata("R1-excerpt.mcap"), topics).unwrap();
    assert!(bag.next_item().unwrap().unwrap().frame.odometry.is_none());
}

#[test]
fn wrong_types_are_named() {
    let topics = BagTopics { image: "/odom".into(), ..BagTopics::default() };
    let Err(error) = BagReader::open(testdata("R1-excerpt.mcap"), topics) else { panic!("opened") };
    let text = error.to_string();
    assert!(text.contains("/odom") && text.contains("nav_msgs/msg/Odometry"), "{text}");
    assert!(text.contains("CompressedImage or sensor_msgs/msg/Image"), "{text}");
}
