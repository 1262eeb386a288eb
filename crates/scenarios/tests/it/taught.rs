//! A camera in a map of SLAM that shows a part of its way.

use visloc_core::{CameraTrajectory, GrayFrame, ImageSource};
use visloc_sim::CameraTour;
use visloc_slam::{
    Slam, SlamConfig,
    map::{KeyframeId, Map},
};
use visloc_vmap::{MapLocalizer, Support, VisualMap};

/// Images that are taught, every third of a walk of twice as many.
const TAUGHT: usize = 60;

fn tour(num: usize) -> CameraTour {
    CameraTour::new("room", 2).unwrap().with_threads(2).with_frames(0, 3 * num, 3)
}

/// A map of the first part of a walk, in the frame of the truth.
fn taught(truth: &CameraTrajectory) -> Map {
    let mut tour = tour(TAUGHT);
    let mut slam = Slam::new(tour.camera(), &SlamConfig::default(), 1).unwrap();
    while let Some(frame) = tour.next_image() {
        let frame = frame.unwrap();
        slam.add_frame(frame.at, frame.image).unwrap();
    }
    let map = VisualMap { map: slam.map().clone(), ..VisualMap::default() };
    let mut map = VisualMap::from_bytes(&map.to_bytes(&slam.session_camera())).unwrap().map;
    let aligned = map.align(map.largest().unwrap(), truth).unwrap();
    assert!(aligned.rmse_m < 0.02, "{aligned:?}");
    map.map
}

fn places(map: &Map, num: usize) -> Vec<(KeyframeId, [f64; 3])> {
    let place = |of: &visloc_slam::map::Keyframe| (*of.center_in_world()).into();
    map.all_keyframes().take(num).map(|(id, keyframe)| (id, place(keyframe))).collect()
}

#[test]
fn a_camera_that_leaves_its_map_is_followed_by_what_it_has_seen_since() {
    let mut tour = tour(2 * TAUGHT);
    let truth = tour.truth();
    let map = taught(&truth);
    let num_taught = map.all_keyframes().count();
    let mut localizer = MapLocalizer::new(&map, Some(1.0), tour.camera(), &SlamConfig::default(), 3).unwrap();
    let mut estimates = Vec::new();
    while let Some(frame) = tour.next_image() {
        let frame = frame.unwrap();
        let known = truth.nearest(frame.at, 0.001).unwrap().world_from_camera;
        if let Some(estimate) = localizer.step(GrayFrame::new(frame.at, frame.image)).unwrap() {
            let apart = known.inverse() * estimate.world_from_camera;
            assert!(apart.translation().norm() < 0.06, "{} m at {}", apart.translation().norm(), frame.at);
            estimates.push(estimate);
        }
    }
    assert!(estimates.len() >= 2 * TAUGHT - 4, "{}", estimates.len());
    let carried: Vec<_> = estimates.iter().filter(|e| e.support == Support::Motion).collect();
    let supports: String =
        estimates.iter().map(|e| if e.support == Support::Map { "m" } else { "-" }).collect();
    assert!(carried.len() > 20, "{supports}");
    assert!(carried.iter().all(|estimate| estimate.is_localized() && estimate.is_carried()));
    let (first, last) = (carried[0], carried[carried.len() - 1]);
    assert!(last.reliability < first.reliability && last.covariance.trace() > first.covariance.trace());
    // What was taught is where it was.
    assert_eq!(places(&map, num_taught), places(localizer.slam().map(), num_taught));
    localizer.slam().map().check().unwrap();
}
