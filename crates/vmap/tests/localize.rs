//! A camera in a map of the rendered clip of a desk that was aligned to the truth.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    CameraTrajectory, GrayFrame, GrayImage, ImageSource, Timestamp,
    geom::{Camera, Rigid3},
};
use visloc_io::sequence::{SequenceRange, open_tum, read_camera_trajectory};
use visloc_slam::{Slam, SlamConfig};
use visloc_vmap::{CameraEstimate, MapLocalizer, ScaleSource, Session, VisualMap};

struct Clip {
    camera: Camera,
    images: Vec<(Timestamp, GrayImage)>,
    truth: CameraTrajectory,
}

fn clip() -> Clip {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip");
    let mut source = open_tum(&folder, SequenceRange::default()).unwrap();
    let camera = *source.camera();
    let image = || source.next_image().map(Result::unwrap).map(|frame| (frame.at, frame.image));
    let images = std::iter::from_fn(image).collect();
    Clip { camera, images, truth: read_camera_trajectory(&folder.join("groundtruth.txt")).unwrap() }
}

fn config() -> SlamConfig {
    let mut config = SlamConfig::default();
    // The clip is short: keyframes have to be near to each other.
    config.mapping.max_shift_ratio = 0.02;
    config
}

/// A map of every second image, in the frame of the truth.
fn taught(clip: &Clip) -> VisualMap {
    let mut slam = Slam::new(&clip.camera, &config(), 1).unwrap();
    for (at, image) in clip.images.iter().step_by(2) {
        slam.add_frame(*at, image.clone()).unwrap();
    }
    let map = VisualMap { map: slam.map().clone(), ..VisualMap::default() };
    let mut map = VisualMap::from_bytes(&map.to_bytes(&slam.session_camera())).unwrap().map;
    let largest = map.largest().unwrap();
    let aligned = map.align(largest, &clip.truth).unwrap();
    assert!(aligned.rmse_m < 0.01, "{aligned:?}");
    assert!(aligned.relative_sigma < 0.05, "{aligned:?}");
    assert_eq!(map.scale(largest).source, ScaleSource::Aligned);
    map.map.check().unwrap();
    map
}

/// Position error in meters, and orientation error in radians.
fn errors(clip: &Clip, estimate: &CameraEstimate) -> (f64, f64) {
    let truth = clip.truth.nearest(estimate.at, 0.01).unwrap().world_from_camera;
    let apart = truth.inverse() * estimate.world_from_camera;
    (apart.translation().norm(), apart.rotation_angle_rad())
}

#[test]
fn new_images_are_localized_in_the_frame_of_the_truth() {
    let clip = clip();
    let map = taught(&clip);
    let mut localizer = MapLocalizer::new(&map.map, Some(1.0), &clip.camera, &config(), 3).unwrap();
    let (mut num, mut last_reliability) = (0, 0.0);
    for (at, image) in clip.images.iter().skip(1).step_by(2) {
        let Some(estimate) = localizer.step(GrayFrame::new(*at, image.clone())).unwrap() else { continue };
        let (meters, radians) = errors(&clip, &estimate);
        // The way of the clip is short and nearly straight: its places tell the turn of the map only to a degree.
        assert!(meters < 0.02 && radians < 0.02, "{meters} m, {radians} rad at {at}");
        assert!(estimate.covariance.iter().all(|value| value.is_finite()));
        last_reliability = estimate.reliability;
        num += usize::from(estimate.is_localized());
    }
    let total = clip.images.len() / 2;
    assert!(num + 2 >= total, "{num} of {total}");
    assert!(last_reliability > 0.95);
}

#[test]
fn a_camera_that_is_carried_away_is_found_again_within_two_images() {
    let clip = clip();
    let map = taught(&clip);
    let mut localizer = MapLocalizer::new(&map.map, None, &clip.camera, &config(), 3).unwrap();
    let (first, last) = (&clip.images[..12], &clip.images[clip.images.len() - 12..]);
    let mut lost = 0;
    for (number, (_, image)) in first.iter().chain(last).chain(first).enumerate() {
        let at = Timestamp::from_secs(number as f64 / 30.0);
        let estimate = localizer.step(GrayFrame::new(at, image.clone())).unwrap();
        lost += usize::from(estimate.is_none_or(|estimate| !estimate.is_localized()));
    }
    assert!(lost <= 6, "{lost} images without a place");
}

#[test]
fn what_is_dark_has_no_place() {
    let clip = clip();
    let map = taught(&clip);
    let mut localizer = MapLocalizer::new(&map.map, Some(1.0), &clip.camera, &config(), 3).unwrap();
    let (width, height) = clip.camera.size_px();
    for number in 0..5 {
        let at = Timestamp::from_secs(f64::from(number) / 30.0);
        let dark = GrayImage::new(width as usize, height as usize);
        assert!(localizer.step(GrayFrame::new(at, dark)).unwrap().is_none());
    }
}

#[test]
fn odometry_carries_a_place_until_the_robot_is_lifted() {
    let clip = clip();
    let map = taught(&clip);
    let mut localizer = MapLocalizer::new(&map.map, Some(1.0), &clip.camera, &config(), 3).unwrap();
    let (width, height) = clip.camera.size_px();
    let mut step = |number: u32, image: Option<&GrayImage>, x_m: Option<f64>| {
        let dark = || GrayImage::new(width as usize, height as usize);
        let odom_from_camera = x_m.map(|x_m| Rigid3::new(Rotation3::identity(), Vector3::x() * x_m));
        let at = Timestamp::from_secs(f64::from(number) / 30.0);
        let frame = GrayFrame::new(at, image.cloned().unwrap_or_else(dark));
        localizer.step(GrayFrame { odom_from_camera, ..frame }).unwrap()
    };
    let mut number = 0;
    let mut next = || {
        number += 1;
        number
    };
    let seen = (0..10).filter_map(|i| step(next(), Some(&clip.images[i].1), Some(0.0))).last().unwrap();
    // There and back again: the way counts, not how far it is from where it began.
    let there = step(next(), None, Some(1.0)).unwrap();
    let back = step(next(), None, Some(0.0)).unwrap();
    assert!(there.is_carried() && back.is_carried() && back.reliability < there.reliability);
    assert!((back.world_from_camera.translation() - seen.world_from_camera.translation()).norm() < 1e-9);
    assert!(back.covariance[(0, 0)] > there.covariance[(0, 0)]);
    assert!(step(next(), None, None).is_none(), "in the air");
    assert!(step(next(), None, Some(0.0)).is_none(), "put down somewhere");
}

#[test]
fn a_map_of_a_robot_has_the_frame_of_its_odometry_and_keeps_it() {
    let clip = clip();
    let mut slam = Slam::new(&clip.camera, &config(), 1).unwrap();
    for (at, image) in &clip.images {
        let truth = clip.truth.nearest(*at, 0.01).unwrap().world_from_camera;
        let turn = Rotation3::from_matrix_unchecked(*truth.rotation());
        let odom_from_camera = Some(Rigid3::new(turn, *truth.translation()));
        slam.add_frame_of_robot(*at, image.clone(), odom_from_camera).unwrap();
    }
    slam.finish();
    let map = VisualMap::default().after(&slam, Session::default());
    let map = VisualMap::from_bytes(&map.to_bytes(&slam.session_camera())).unwrap().map;
    let largest = map.largest().unwrap();
    assert_eq!((map.scale(largest).source, map.is_level(largest)), (ScaleSource::Odometry, true));
    map.map.check().unwrap();
    for pose in map.way(largest).poses() {
        let truth = clip.truth.nearest(pose.at, 0.01).unwrap().world_from_camera;
        let apart = truth.inverse() * pose.world_from_camera;
        assert!(apart.translation().norm() < 0.05 && apart.rotation_angle_rad() < 0.02, "{apart:?}");
    }
    // A camera on no robot goes on in it.
    let before = map.way(largest);
    let mut slam =
        Slam::resume(map.map.clone(), &clip.camera, &config(), 1, visloc_slam::Schedule::Sequential).unwrap();
    for (number, (_, image)) in clip.images.iter().enumerate() {
        slam.add_frame(Timestamp::from_secs(2e9 + number as f64 / 30.0), image.clone()).unwrap();
    }
    slam.finish();
    let after = map.after(&slam, Session::default());
    assert!(after.is_level(largest) && after.scale(largest).source == ScaleSource::Odometry);
    let (first, now) = (before.poses()[0], after.way(largest).poses()[0]);
    assert!((first.world_from_camera.translation() - now.world_from_camera.translation()).norm() < 0.01);
}
