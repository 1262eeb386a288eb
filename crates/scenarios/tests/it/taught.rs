//! A camera in a map of SLAM that shows a part of its way.

use visloc_core::{CameraTrajectory, GrayFrame, ImageSource, Source};
use visloc_sim::{CameraTour, Scenario, Simulation};
use visloc_slam::{
    Slam, SlamConfig,
    map::{KeyframeId, Map},
};
use visloc_vmap::{MapLocalizer, Session, Support, VisualMap};

/// Images that are taught, every third of a walk of twice as many.
const TAUGHT: usize = 60;

fn tour(num: usize) -> CameraTour {
    CameraTour::new("room", 2).unwrap().with_threads(2).with_frames(0, 3 * num, 3)
}

/// A map of the first part of a walk, in the frame of the truth.
fn taught(truth: &CameraTrajectory) -> Map {
    let mut tour = tour(TAUGHT);
    let mut slam = Slam::new(tour.camera(), &SlamConfig::default(), 1).unwrap();
    while let Some(frame) = tour.next_item() {
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
    while let Some(frame) = tour.next_item() {
        let frame = frame.unwrap();
        let known = truth.nearest(frame.at, 0.001).unwrap().world_from_camera;
        if let Some(estimate) = localizer.step(GrayFrame::new(frame.at, frame.image)).unwrap() {
            let apart = known.inverse() * estimate.world_from_camera;
            assert!(apart.translation().norm() < 0.06, "{} m at {}", apart.translation().norm(), frame.at);
            // What has no depth of its own tells nothing where the landmarks do.
            let features = &localizer.outcome().unwrap().features;
            let num_landmarks = features.iter().filter(|(_, is_converged)| *is_converged).count();
            let is_known = num_landmarks >= SlamConfig::default().tracking.min_matches;
            assert!(!is_known || num_landmarks == features.len(), "{num_landmarks} of {}", features.len());
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

/// Where a view reaches over the border of what was taught, little of it is found at first, and from there the rest.
#[test]
fn a_camera_is_found_from_nothing_where_little_of_its_view_is_mapped() {
    let mut tour = tour(2 * TAUGHT);
    let (truth, camera) = (tour.truth(), *tour.camera());
    let map = taught(&truth);
    let images: Vec<GrayFrame> = std::iter::from_fn(|| tour.next_item())
        .map(Result::unwrap)
        .map(|frame| GrayFrame::new(frame.at, frame.image))
        .collect();
    let is_found = |first: usize, seed: u64| {
        let mut localizer =
            MapLocalizer::new(&map, Some(1.0), &camera, &SlamConfig::default(), seed).unwrap();
        let mut steps = images[first..first + 2].iter();
        steps.any(|image| {
            let Some(estimate) = localizer.step(image.clone()).unwrap().filter(|e| e.is_localized()) else {
                return false;
            };
            let known = truth.nearest(image.at, 0.001).unwrap().world_from_camera;
            let off_m = (known.inverse() * estimate.world_from_camera).translation().norm();
            assert!(off_m < 0.1, "{off_m} m from image {first}, seed {seed}");
            true
        })
    };
    let starts = (TAUGHT..2 * TAUGHT - 2).flat_map(|first| (1..=3).map(move |seed| (first, seed)));
    // In the middle of this part nothing is seen that was taught.
    let num_found = starts.filter(|(first, seed)| is_found(*first, *seed)).count();
    assert!(num_found >= 87, "{num_found}");
}

/// A robot that walks straight along the office corridor while its head turns from side to side.
fn straight_walk() -> Scenario {
    let text = "map = \"office\"\nduration_secs = 10.0\nstart = { x_m = 2.2, y_m = 0.0, yaw_deg = 0.0 }\n[robot]\nneck_height_m = 0.42\n\
         [robot.head]\npan_deg = 38.0\npan_period_secs = 7.0\ntilt_deg = 6.0\n[[motion]]\nstand.secs = 0.5\n[[motion]]\n\
         walk = { through_m = [[4.6, 0.0]], speed_m_per_s = 0.3 }\n\
         [light]\nunevenness = 0.6\nambient = 0.5\n";
    Scenario::parse("walk", text).unwrap()
}

/// Doors look alike, and a robot that starts beside its map's way may be taken for one in front of another. It does not stay there.
#[test]
fn a_place_that_is_in_doubt_is_left_where_more_is_seen_elsewhere() {
    let mut taught =
        Simulation::new(&Scenario::load("office-walk").unwrap(), 1).unwrap().with_num_frames(600);
    let mut slam = Slam::new(taught.camera(), &SlamConfig::default(), 1).unwrap();
    while let Some(frame) = taught.next_item() {
        let GrayFrame { at, image, odom_from_camera, .. } = GrayFrame::of_robot(frame.unwrap());
        slam.add_frame_of_robot(at, image, odom_from_camera).unwrap();
    }
    slam.finish();
    let map = VisualMap::default().after(&slam, Session::default());
    for seed in [3, 4] {
        let mut driven = Simulation::new(&straight_walk(), seed).unwrap();
        let camera = *driven.camera();
        let mut localizer = MapLocalizer::in_map(&map, &camera, &SlamConfig::default(), seed).unwrap();
        let (mut num, mut num_wrong) = (0, 0);
        while let Some(frame) = driven.next_item() {
            let frame = frame.unwrap();
            let truth = frame.truth.unwrap().world_from_robot;
            if let Some(estimate) = localizer.step(GrayFrame::of_robot(frame)).unwrap() {
                let at = estimate.world_from_camera.translation();
                num += 1;
                num_wrong += usize::from((at.x + 2.2 - truth.x_m).hypot(at.y - truth.y_m) > 0.5);
            }
        }
        assert!(num > 150 && num_wrong < num / 10, "seed {seed}: {num_wrong} of {num}");
    }
}
