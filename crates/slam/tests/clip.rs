//! The whole system on a short rendered clip: 60 images of an orbit round a desk, 320 x 240 px.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use nalgebra::{Point2, Rotation3, Vector3};
use visloc_core::{
    CameraPose, CameraTrajectory, GrayImage, ImageSource, Source, Timestamp,
    eval::camera::{Alignment, absolute_error, associate},
    geom::Camera,
};
use visloc_io::sequence::{SequenceRange, open_tum, read_camera_trajectory};
use visloc_slam::{FrameError, Slam, SlamConfig, odometry::OdomFromCamera};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip")
}

fn run(seed: u64) -> (Slam, CameraTrajectory) {
    run_with_odometry(seed, None)
}

fn run_with_odometry(seed: u64, odometry: Option<OdomFromCamera>) -> (Slam, CameraTrajectory) {
    let mut source = open_tum(&folder(), SequenceRange::default()).unwrap();
    let mut slam = Slam::new(source.camera(), &SlamConfig::default(), seed).unwrap();
    while let Some(frame) = source.next_item() {
        let frame = frame.unwrap();
        slam.add_frame_of_robot(frame.at, frame.image, odometry).unwrap();
    }
    slam.map().check().unwrap();
    let mut trajectory = CameraTrajectory::new();
    for pose in slam.trajectory() {
        trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera }).unwrap();
    }
    (slam, trajectory)
}

#[test]
fn follows_the_camera_to_a_centimeter() {
    let truth = read_camera_trajectory(&folder().join("groundtruth.txt")).unwrap();
    let mut good = 0;
    for seed in 1..=5 {
        let (_, trajectory) = run(seed);
        let pairs = associate(&truth, &trajectory, 0.01);
        let error = absolute_error(&pairs, Alignment::Similarity);
        good += u32::from(pairs.len() >= 54 && error.is_some_and(|error| error.statistics.rmse < 0.01));
    }
    assert!(good >= 4, "{good} of 5 seeds");
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let bits = |trajectory: &CameraTrajectory| -> Vec<u64> {
        let translation = |pose: &CameraPose| *pose.world_from_camera.translation();
        trajectory
            .poses()
            .iter()
            .flat_map(|p| translation(p).iter().map(|v| v.to_bits()).collect::<Vec<_>>())
            .collect()
    };
    let once = bits(&run(1).1);
    assert_eq!(once, bits(&run(1).1));
    let nowhere = OdomFromCamera::new(Rotation3::identity(), Vector3::new(f64::NAN, 0.0, 0.0));
    assert_eq!(once, bits(&run_with_odometry(1, Some(nowhere)).1), "no number is no odometry");
}

#[test]
fn bad_frames_are_refused_or_survived() {
    let mut source = open_tum(&folder(), SequenceRange::default()).unwrap();
    let mut slam = Slam::new(source.camera(), &SlamConfig::default(), 1).unwrap();
    let first = source.next_item().unwrap().unwrap();
    slam.add_frame(first.at, first.image.clone()).unwrap();
    assert!(matches!(slam.add_frame(first.at, first.image), Err(FrameError::Time { .. })));
    let small = GrayImage::new(10, 10);
    assert!(matches!(slam.add_frame(first.at + 1.0, small), Err(FrameError::Size { .. })));
    for i in 0..40 {
        let mut image = GrayImage::new(320, 240);
        if i % 2 == 1 {
            image.data_mut().fill(255);
        }
        slam.add_frame(Timestamp::from_secs(1.8e9 + f64::from(i)), image).unwrap();
    }
    assert!(slam.trajectory().is_empty());
}

/// An image as the camera would have taken it, had it been rolled about its axis.
fn rolled(image: &GrayImage, camera: &Camera, angle_rad: f64) -> GrayImage {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad);
    let mut out = GrayImage::new(image.width(), image.height());
    for (i, value) in out.data_mut().iter_mut().enumerate() {
        let px = Point2::new((i % image.width()) as f64, (i / image.width()) as f64);
        let Ok(from) = camera.project(&(turn * camera.bearing(&px)).into()) else { continue };
        let (x, y) = (from.x.floor(), from.y.floor());
        let is_inside =
            x >= 0.0 && y >= 0.0 && x + 1.0 < image.width() as f64 && y + 1.0 < image.height() as f64;
        if is_inside {
            let pixel = |dx, dy| f64::from(image.get(x as usize + dx, y as usize + dy));
            let row = |dy| pixel(0, dy) + (from.x - x) * (pixel(1, dy) - pixel(0, dy));
            *value = (row(0) + (from.y - y) * (row(1) - row(0))).round() as u8;
        }
    }
    out
}

#[test]
fn a_camera_that_turns_far_from_one_image_to_the_next_is_followed() {
    for seed in 1..=5 {
        let mut source = open_tum(&folder(), SequenceRange::default()).unwrap();
        let camera = *source.camera();
        let mut slam = Slam::new(&camera, &SlamConfig::default(), seed).unwrap();
        let mut num_tracked = 0;
        while let Some(frame) = source.next_item() {
            let frame = frame.unwrap();
            // It turns there and back soon after the start, while a map that is lost is given up.
            let angle_rad = if (5..10).contains(&num_tracked) { 0.6 } else { 0.0 };
            let outcome = slam.add_frame(frame.at, rolled(&frame.image, &camera, angle_rad)).unwrap();
            let is_tracked = outcome.camera_from_world.is_some();
            num_tracked += usize::from(is_tracked);
            assert_eq!(is_tracked, num_tracked > 0, "seed {seed} at {num_tracked}: {:?}", outcome.state);
        }
        assert!(num_tracked > 30, "seed {seed}: {num_tracked}");
    }
}
