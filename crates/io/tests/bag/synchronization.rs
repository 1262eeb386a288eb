//! Messages of several topics, joined by their stamps.

use nalgebra::{Isometry3, Vector3};
use visloc_core::{
    GroundContact, Timestamp,
    geom::{Camera, PlanarPose},
};
use visloc_io::{
    bag::{
        BagTopics, EncodedImage, ExpectedInputs, GivenInputs, ImagePayload, SensorMessage, StampedTransform,
        SyncOutcome, SynchronizedFrame, Synchronizer,
    },
    image_codec,
};

use crate::support::frame;

fn at(secs: f64) -> Timestamp {
    Timestamp::from_secs(100.0 + secs)
}

fn image(secs: f64) -> SensorMessage {
    let bytes = image_codec::encode_png(&frame(0).frame.image).unwrap();
    SensorMessage::Image(EncodedImage {
        at: at(secs),
        frame_id: "/camera".into(),
        payload: ImagePayload::Compressed(bytes),
    })
}

fn camera(secs: f64) -> SensorMessage {
    SensorMessage::CameraInfo(at(secs), Camera::pinhole((64, 48), (70.0, 70.0), (31.5, 23.5)).unwrap())
}

fn odometry(secs: f64) -> SensorMessage {
    SensorMessage::Odometry(at(secs), PlanarPose::new(secs, 0.0, 0.0))
}

fn transform(secs: f64, parent: &str, child: &str) -> StampedTransform {
    let parent_from_child = Isometry3::translation(secs, 0.0, 0.5);
    StampedTransform { at: at(secs), parent: parent.into(), child: child.into(), parent_from_child }
}

fn head(secs: f64) -> SensorMessage {
    SensorMessage::Transforms(vec![transform(secs, "base_footprint", "camera")])
}

fn synchronizer() -> Synchronizer {
    let expected = ExpectedInputs { has_odometry: true, ..ExpectedInputs::default() };
    Synchronizer::new(&BagTopics::default(), expected)
}

fn pop(synchronizer: &mut Synchronizer) -> Option<SynchronizedFrame> {
    match synchronizer.pop()? {
        SyncOutcome::Frame(frame) => Some(*frame),
        SyncOutcome::Unusable(reason) => panic!("{reason}"),
    }
}

#[test]
fn a_picture_waits_for_later_messages_and_is_interpolated_between() {
    let mut synchronizer = synchronizer();
    for message in [camera(0.0), odometry(0.0), head(0.0), image(0.05)] {
        synchronizer.push(message);
    }
    assert!(pop(&mut synchronizer).is_none());
    synchronizer.push(odometry(0.1));
    assert!(pop(&mut synchronizer).is_none());
    synchronizer.push(head(0.1));
    let frame = pop(&mut synchronizer).unwrap();
    assert!(!frame.has_held_values);
    assert!((frame.source_frame.frame.odometry.unwrap().x_m - 0.05).abs() < 1e-9);
    let translation = frame.source_frame.frame.robot_from_camera.translation().to_owned();
    assert!((translation - Vector3::new(0.05, 0.0, 0.5)).norm() < 1e-9);
}

#[test]
fn order_of_messages_with_one_stamp_does_not_matter() {
    let parts = [image(0.1), camera(0.1), odometry(0.1), head(0.1)];
    for first in 0..parts.len() {
        let mut synchronizer = synchronizer();
        for i in 0..parts.len() {
            assert!(pop(&mut synchronizer).is_none());
            synchronizer.push(parts[(first + i) % parts.len()].clone());
        }
        let frame = pop(&mut synchronizer).unwrap();
        assert!((frame.source_frame.frame.odometry.unwrap().x_m - 0.1).abs() < 1e-9);
        assert!(synchronizer.skipped().is_empty());
    }
}

#[test]
fn a_silent_topic_costs_a_quarter_of_a_second_and_is_flagged() {
    let mut synchronizer = synchronizer();
    for message in [camera(0.0), odometry(0.0), head(0.0), image(0.1)] {
        synchronizer.push(message);
    }
    synchronizer.push(head(0.3));
    assert!(pop(&mut synchronizer).is_none());
    synchronizer.push(head(0.36));
    let held = pop(&mut synchronizer).unwrap();
    assert!(held.has_held_values && held.source_frame.frame.odometry == Some(PlanarPose::default()));
    // half a second after its last message there is no odometry
    synchronizer.push(image(0.7));
    synchronizer.push(head(1.0));
    assert!(pop(&mut synchronizer).unwrap().source_frame.frame.odometry.is_none());
}

/// Odometry of 10 Hz that ends at 1 s, by a robot that walks 1 m/s: what an image after that is told. A robot whose odometry is missing
/// has not stopped.
#[test]
fn odometry_goes_on_until_its_next_sample_is_overdue() {
    let told = |secs: f64| {
        let mut synchronizer = synchronizer();
        let samples = (0..=10).map(|i| odometry(0.1 * f64::from(i)));
        for message in
            [camera(0.0)].into_iter().chain(samples).chain([head(secs), image(secs), head(secs + 0.3)])
        {
            synchronizer.push(message);
        }
        let frame = pop(&mut synchronizer).unwrap();
        assert!(frame.has_held_values);
        frame.source_frame.frame.odometry.map(|pose| pose.x_m)
    };
    assert!((told(1.03).unwrap() - 1.03).abs() < 1e-6 && (told(1.12).unwrap() - 1.12).abs() < 1e-6);
    assert_eq!((told(1.2), told(1.4)), (None, None));
}

#[test]
fn pictures_without_pose_or_calibration_are_left_out_with_a_reason() {
    let mut synchronizer = synchronizer();
    synchronizer.push(image(0.0));
    synchronizer.push(odometry(0.3));
    assert!(pop(&mut synchronizer).is_none());
    synchronizer.push(camera(0.3));
    synchronizer.push(image(0.3));
    synchronizer.finish();
    assert!(pop(&mut synchronizer).is_none());
    let reasons: Vec<_> = synchronizer.skipped().iter().map(|skipped| skipped.reason.as_str()).collect();
    assert!(
        reasons[0].contains("/camera/camera_info") && reasons[1].contains("'base_footprint' to 'camera'")
    );
}

#[test]
fn static_and_moving_transforms_chain() {
    let mut synchronizer = synchronizer();
    let fixed = vec![transform(0.25, "head", "camera"), transform(0.0, "base_footprint", "torso")];
    synchronizer.push(SensorMessage::StaticTransforms(fixed));
    for message in [camera(0.1), odometry(0.1), image(0.1)] {
        synchronizer.push(message);
    }
    synchronizer.push(SensorMessage::Transforms(vec![transform(0.1, "torso", "head")]));
    let frame = pop(&mut synchronizer).unwrap().source_frame.frame;
    let translation = frame.robot_from_camera.translation().to_owned();
    assert!((translation - Vector3::new(0.35, 0.0, 1.5)).norm() < 1e-9);
}

#[test]
fn foot_sensors_hold_their_last_value_and_pressure_wins() {
    let mut synchronizer = synchronizer();
    synchronizer.push(SensorMessage::FootContact(at(-7.0e6), true));
    let mut contact = |secs: f64, foot: Option<SensorMessage>| {
        for message in [camera(secs), odometry(secs), head(secs)].into_iter().chain(foot) {
            synchronizer.push(message);
        }
        synchronizer.push(image(secs));
        pop(&mut synchronizer).unwrap().source_frame.frame.ground_contact
    };
    assert_eq!(contact(0.1, None), Some(GroundContact::Contact(true)));
    let lifted = SensorMessage::FootContact(at(0.2), false);
    assert_eq!(contact(0.2, Some(lifted)), Some(GroundContact::Contact(false)));
    assert_eq!(contact(0.3, None), Some(GroundContact::Contact(false)));
    let forces = SensorMessage::FootPressure(at(0.4), [5.0; 8]);
    assert_eq!(contact(0.4, Some(forces)), Some(GroundContact::Pressure([5.0; 8])));
}

#[test]
fn one_stamp_far_ahead_does_not_end_the_odometry() {
    let mut synchronizer = synchronizer();
    let mut num_with_odometry = 0;
    for i in 0..40 {
        let secs = 0.1 * f64::from(i);
        let odometry_secs = if i == 10 { 5000.0 } else { secs };
        for message in [camera(secs), odometry(odometry_secs), head(secs), image(secs)] {
            synchronizer.push(message);
        }
        while let Some(frame) = pop(&mut synchronizer) {
            let odometry = frame.source_frame.frame.odometry;
            assert!(odometry.is_none_or(|pose| pose.x_m < 10.0));
            num_with_odometry += usize::from(odometry.is_some());
        }
    }
    assert!(num_with_odometry >= 35, "{num_with_odometry}");
}

#[test]
fn what_is_given_wins_over_messages_and_is_not_waited_for() {
    let place = frame(3).frame.robot_from_camera;
    let other = Camera::pinhole((64, 48), (90.0, 90.0), (31.5, 23.5)).unwrap();
    let given = GivenInputs { camera: Some(other), robot_from_camera: Some(place), ..GivenInputs::default() };
    let mut synchronizer =
        Synchronizer::new(&BagTopics::default(), ExpectedInputs::default()).with_given(given);
    synchronizer.push(image(0.1));
    let alone = pop(&mut synchronizer).unwrap().source_frame.frame;
    assert_eq!((alone.camera, alone.robot_from_camera), (other, place));
    for message in [camera(0.2), head(0.2), image(0.2)] {
        synchronizer.push(message);
    }
    let over = pop(&mut synchronizer).unwrap().source_frame.frame;
    assert_eq!((over.camera, over.robot_from_camera), (other, place));
    // It survives a publisher that begins anew.
    synchronizer.restart();
    synchronizer.push(image(0.05));
    assert_eq!(pop(&mut synchronizer).unwrap().source_frame.frame.camera, other);
}
