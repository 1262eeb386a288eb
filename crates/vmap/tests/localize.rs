//! A camera in a map of the rendered clip of a desk that was aligned to the truth.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    CameraTrajectory, GrayFrame, GrayImage, ImageSource, Source, Timestamp,
    geom::{Camera, Rigid3},
};
use visloc_io::sequence::{SequenceRange, open_tum, read_camera_trajectory};
use visloc_slam::{Slam, SlamConfig, mapping::GivenViews};
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
    let image = || source.next_item().map(Result::unwrap).map(|frame| (frame.at, frame.image));
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
fn two_images_are_enough_where_few_places_are_tried() {
    let clip = clip();
    let map = taught(&clip);
    let mut config = config();
    config.relocation.max_tries = 2;
    let (mut num, mut num_first) = (0, 0);
    for start in (0..clip.images.len() - 2).step_by(9) {
        let mut localizer = MapLocalizer::in_map(&map, &clip.camera, &config, start as u64).unwrap();
        let is_found = |(at, image): &(Timestamp, GrayImage)| {
            localizer.step(GrayFrame::new(*at, image.clone())).unwrap().is_some_and(|e| e.is_localized())
        };
        let found: Vec<bool> = clip.images[start..start + 2].iter().map(is_found).collect();
        num += 1;
        num_first += usize::from(found[0]);
        assert!(found[1], "from image {start}");
    }
    assert!(num_first > num / 2, "{num_first} of {num}");
}

#[test]
fn a_localizer_shares_the_landmarks_of_its_map() {
    let clip = clip();
    let map = taught(&clip);
    let localizer = MapLocalizer::in_map(&map, &clip.camera, &config(), 3).unwrap();
    let copy = localizer.slam().map();
    assert!(map.map.all_landmarks().count() > 100);
    assert!(map.map.all_landmarks().all(|(id, landmark)| std::ptr::eq(landmark, copy.landmark(id))));
}

#[test]
fn nobody_is_looked_for_in_an_empty_map() {
    let error = MapLocalizer::in_map(&VisualMap::default(), &clip().camera, &config(), 3).unwrap_err();
    assert_eq!(error.to_string(), "map: expected at least one keyframe, found none");
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
    for pose in map.ways(largest)[0].poses() {
        let truth = clip.truth.nearest(pose.at, 0.01).unwrap().world_from_camera;
        let apart = truth.inverse() * pose.world_from_camera;
        assert!(apart.translation().norm() < 0.05 && apart.rotation_angle_rad() < 0.02, "{apart:?}");
    }
    // A camera on no robot goes on in it.
    let before = map.ways(largest).remove(0);
    let mut slam =
        Slam::resume(map.map.clone(), &clip.camera, &config(), 1, visloc_slam::Schedule::Sequential).unwrap();
    for (number, (_, image)) in clip.images.iter().enumerate() {
        slam.add_frame(Timestamp::from_secs(2e9 + number as f64 / 30.0), image.clone()).unwrap();
    }
    slam.finish();
    let after = map.after(&slam, Session::default());
    assert!(after.is_level(largest) && after.scale(largest).source == ScaleSource::Odometry);
    let (first, now) = (before.poses()[0], after.ways(largest)[0].poses()[0]);
    assert!((first.world_from_camera.translation() - now.world_from_camera.translation()).norm() < 0.01);
}

/// A map of some images, as a file has it.
fn map_of<'a>(clip: &Clip, images: impl Iterator<Item = &'a (Timestamp, GrayImage)>) -> VisualMap {
    let mut slam = Slam::new(&clip.camera, &config(), 1).unwrap();
    for (at, image) in images {
        slam.add_frame(*at, image.clone()).unwrap();
    }
    let map = VisualMap::default().after(&slam, Session::default());
    VisualMap::from_bytes(&map.to_bytes(&slam.session_camera())).unwrap().map
}

#[test]
fn two_maps_of_one_desk_become_one_in_the_frame_that_is_known() {
    let clip = clip();
    let first = map_of(&clip, clip.images[..40].iter());
    let mut second = map_of(&clip, clip.images[20..].iter());
    let largest = second.largest().unwrap();
    second.align(largest, &clip.truth).unwrap();
    let counts = |map: &VisualMap| (map.map.all_keyframes().count(), map.map.all_landmarks().count());
    let (a, b) = (counts(&first), counts(&second));
    let before = second.ways(largest).remove(0);
    let (merged, how) = first.merged_with(second, &config(), 1).unwrap().unwrap();
    merged.map.check().unwrap();
    assert!(how.num_keyframes >= 3 && how.num_same > 20, "{how:?}");
    assert_eq!((merged.map.maps().len(), counts(&merged).0), (1, a.0 + b.0));
    assert!(counts(&merged).1 < a.1 + b.1, "landmarks that are the same became one");
    // The aligned map stays where it is, though it was named second, and the other one came to it.
    let map = merged.largest().unwrap();
    assert_eq!(merged.scale(map).source, ScaleSource::Aligned);
    let ways = merged.ways(map);
    let num_poses: usize = ways.iter().map(|way| way.poses().len()).sum();
    assert_eq!((ways.len(), num_poses), (2, a.0 + b.0));
    for pose in before.poses() {
        let now = merged
            .map
            .all_keyframes()
            .any(|(_, k)| k.camera_from_world().inverse() == pose.world_from_camera);
        assert!(now, "{:?} has moved", pose.at);
    }
    for pose in ways.iter().flat_map(CameraTrajectory::poses) {
        let truth = clip.truth.nearest(pose.at, 0.01).unwrap().world_from_camera;
        let apart = (truth.translation() - pose.world_from_camera.translation()).norm();
        assert!(apart < 0.05, "{apart} m at {:?}", pose.at);
    }
}

#[test]
fn maps_of_different_places_stay_two() {
    let clip = clip();
    let map = map_of(&clip, clip.images.iter());
    // The other way up it would be the same desk.
    let mirrored = |(at, image): &(Timestamp, GrayImage)| {
        let data = image.data().chunks(image.width()).flat_map(|row| row.iter().rev()).copied().collect();
        (*at, GrayImage::from_raw(image.width(), image.height(), data).unwrap())
    };
    let images: Vec<(Timestamp, GrayImage)> = clip.images.iter().map(mirrored).collect();
    let other = map_of(&clip, images.iter());
    let apart = map.merged_with(other, &config(), 1).err().unwrap();
    assert!(apart.num_agreeing < 3 && apart.num_keyframes > 0, "{apart:?}");
}

#[test]
fn a_smaller_map_still_finds_the_camera() {
    let clip = clip();
    let mut map = taught(&clip);
    let largest = map.largest().unwrap();
    let before = map.map.all_keyframes().count();
    let thinned = map.trim(largest, 4);
    assert_eq!((map.map.all_keyframes().count(), thinned.num_keyframes), (4, before - 4));
    map.map.check().unwrap();
    let camera = *map.map.all_keyframes().next().unwrap().1.foreign.as_deref().unwrap();
    let map = VisualMap::from_bytes(&map.to_bytes(&camera)).unwrap().map;
    let mut localizer = MapLocalizer::in_map(&map, &clip.camera, &config(), 3).unwrap();
    let (at, image) = &clip.images[1];
    let estimate = localizer.step(GrayFrame::new(*at, image.clone())).unwrap().unwrap();
    assert!(errors(&clip, &estimate).0 < 0.03);
}

#[test]
fn a_map_of_views_with_given_poses_locates_the_views_between() {
    let clip = clip();
    let mut views = GivenViews::new(&clip.camera, &config()).unwrap();
    for (at, image) in clip.images.iter().step_by(6) {
        let pose = clip.truth.nearest(*at, 0.01).unwrap().world_from_camera;
        views.add(*at, image.clone(), pose.inverse()).unwrap();
    }
    let small = GrayImage::new(10, 10);
    assert!(views.add(Timestamp::from_secs(3e9), small, Rigid3::identity()).is_err());
    let map = views.finish();
    map.check().unwrap();
    for (_, keyframe) in map.keyframes() {
        let truth = clip.truth.nearest(keyframe.at, 0.01).unwrap().world_from_camera;
        let apart = truth.inverse() * keyframe.camera_from_world().inverse();
        assert!(apart.translation().norm() < 1e-9 && apart.rotation_angle_rad() < 1e-6, "the poses stay");
    }
    assert!(map.landmarks().count() > 100, "{}", map.landmarks().count());
    let camera = visloc_slam::map::SessionCamera::as_calibrated(&clip.camera);
    let map = VisualMap { map, ..VisualMap::default() };
    let map = VisualMap::from_bytes(&map.to_bytes(&camera)).unwrap().map;
    let mut num = 0;
    for (at, image) in clip.images.iter().skip(3).step_by(6) {
        let mut localizer = MapLocalizer::in_map(&map, &clip.camera, &SlamConfig::default(), 3).unwrap();
        let Some(estimate) = localizer.step(GrayFrame::new(*at, image.clone())).unwrap() else { continue };
        let (meters, radians) = errors(&clip, &estimate);
        assert!(meters < 0.02 && radians < 0.02, "{meters} m, {radians} rad at {at}");
        num += usize::from(estimate.is_localized());
    }
    assert!(num >= 9, "{num} of 10");
}

#[test]
fn a_place_that_is_there_twice_is_claimed_once_the_camera_sees_what_only_one_of_them_has() {
    let clip = clip();
    let whole = map_of(&clip, clip.images.iter());
    // The first part of the desk is there a second time, in a map of its own.
    let part = map_of(&clip, clip.images[..30].iter());
    let of_whole = whole.largest().unwrap();
    for seed in [3, 4, 5] {
        let mut twice = whole.map.clone();
        twice.append_all(&part.map);
        let mut localizer = MapLocalizer::new(&twice, None, &clip.camera, &config(), seed).unwrap();
        let mut last = None;
        for (number, (at, image)) in clip.images.iter().enumerate().skip(1).step_by(2) {
            let estimate = localizer.step(GrayFrame::new(*at, image.clone())).unwrap().unwrap();
            if number < 16 {
                let places = localizer.hypotheses();
                assert!(!estimate.is_localized(), "seed {seed}: {} at {number}", estimate.reliability);
                assert!(places.len() == 2 && places[0].map != places[1].map, "{places:?}");
                assert!(places.iter().all(|place| place.probability > 0.15), "{places:?}");
            }
            last = Some(estimate);
        }
        let last = last.unwrap();
        assert!(last.is_localized() && last.map == of_whole, "seed {seed}: {last:?}");
        let places = localizer.hypotheses();
        assert!(places[0].map == of_whole && places[1..].iter().all(|place| place.probability < 0.1));
    }
}

#[test]
fn a_map_in_which_others_went_on_is_aligned_to_the_truth_of_one_of_them() {
    let clip = clip();
    let first = map_of(&clip, clip.images[..40].iter());
    // By the clock of the second session its images were taken when those of the first one were.
    let times = clip.images.iter().map(|(at, _)| *at);
    let again: Vec<_> = times.zip(clip.images[20..].iter().map(|(_, image)| image.clone())).collect();
    let second = map_of(&clip, again.iter());
    let mut alone = map_of(&clip, clip.images[..40].iter());
    let expected = alone.align(alone.largest().unwrap(), &clip.truth).unwrap();
    let (mut merged, _) = first.merged_with(second, &config(), 1).unwrap().unwrap();
    let map = merged.largest().unwrap();
    assert_eq!(merged.ways(map).len(), 2);
    let mut scaled = merged.clone();
    let aligned = merged.align(map, &clip.truth).unwrap();
    assert_eq!(aligned.num_pairs, expected.num_pairs);
    assert!((aligned.scale / expected.scale - 1.0).abs() < 0.02, "{aligned:?}, {expected:?}");
    // Seconds after the first keyframe are those of the first session.
    let [from, to] = [0.0, 1.0].map(|secs| clip.images[0].0 + secs);
    let place = |at| *clip.truth.nearest(at, 0.02).unwrap().world_from_camera.translation();
    let meters = (place(from) - place(to)).norm();
    let between = scaled.scale_by_distance(map, [0.0, 1.0], meters).unwrap();
    assert!((between.scale / expected.scale - 1.0).abs() < 0.1, "{between:?}, {expected:?}");
}

#[test]
fn images_of_half_the_size_are_found() {
    let clip = clip();
    let map = taught(&clip);
    let camera = clip.camera.scaled(0.5);
    for (start, (at, image)) in clip.images.iter().enumerate().step_by(9) {
        let mut localizer = MapLocalizer::in_map(&map, &camera, &config(), start as u64).unwrap();
        let estimate = localizer.step(GrayFrame::new(*at, image.shrunk(2))).unwrap();
        let (meters, _) = errors(&clip, &estimate.unwrap_or_else(|| panic!("image {start} is not found")));
        assert!(meters < 0.03, "image {start}: {meters} m off");
    }
}
