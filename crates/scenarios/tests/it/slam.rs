//! SLAM on simulated tours: how far it is from the truth, and that the same tour gives the same bits.

use visloc_core::{
    CameraPose, CameraTrajectory, GrayImage, ImageSource, Source,
    eval::camera::{Alignment, absolute_error, associate},
};
use visloc_sim::{CameraTour, Scenario, Simulation};
use visloc_slam::{Slam, SlamConfig};

/// Share of the images with a pose, and RMSE after alignment, meters.
fn follow(mut tour: CameraTour, seed: u64) -> (f64, f64) {
    let truth = tour.truth();
    let mut slam = Slam::new(tour.camera(), &SlamConfig::default(), seed).unwrap();
    while let Some(frame) = tour.next_item() {
        let frame = frame.unwrap();
        slam.add_frame(frame.at, frame.image).unwrap();
    }
    let mut estimate = CameraTrajectory::new();
    for pose in slam.trajectory() {
        estimate.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera }).unwrap();
    }
    let pairs = associate(&truth, &estimate, 0.001);
    let rmse =
        absolute_error(&pairs, Alignment::Similarity).map_or(f64::INFINITY, |error| error.statistics.rmse);
    (pairs.len() as f64 / truth.poses().len() as f64, rmse)
}

fn tour(name: &str, seed: u64) -> CameraTour {
    CameraTour::new(name, seed).unwrap().with_threads(2)
}

#[test]
fn rooms_are_followed_to_two_centimeters() {
    let results: Vec<(f64, f64)> =
        (1..=3).map(|seed| follow(tour("room", seed).with_frames(0, 200, 1), seed)).collect();
    let good = results.iter().filter(|(coverage, rmse)| *coverage > 0.95 && *rmse < 0.02).count();
    assert!(good >= 2, "{results:?}");
}

#[test]
fn people_who_walk_by_do_not_move_the_camera() {
    let (coverage, rmse) = follow(tour("walking", 1), 1);
    assert!(coverage > 0.9 && rmse < 0.02, "{coverage}, {rmse} m");
}

#[test]
fn images_do_not_depend_on_threads_or_range() {
    let images = |tour: CameraTour| -> Vec<_> {
        let mut tour = tour.with_frames(3, 12, 2);
        std::iter::from_fn(|| tour.next_item()).map(|frame| frame.unwrap()).collect()
    };
    let small = |seed| CameraTour::new("walking", seed).unwrap().with_size((160, 120)).unwrap();
    let one = images(small(5));
    let three = images(small(5).with_threads(3));
    assert_eq!((one.len(), three.len()), (5, 5));
    assert!(one.iter().zip(&three).all(|(a, b)| a.at == b.at && a.image == b.image));
    let other = images(small(6));
    assert!(other[0].image != one[0].image);
}

/// A robot that walks over a field with its head panning; its odometry has no error of scale.
#[test]
fn odometry_gives_a_robots_map_its_meters_and_carries_it_on() {
    let mut scenario = Scenario::load("tour").unwrap();
    scenario.robot.odometry.scale_error = [0.0, 0.0];
    let mut robot = Simulation::new(&scenario, 1).unwrap().with_num_frames(750).with_threads(2);
    let mut slam: Option<Slam> = None;
    let mut truth = CameraTrajectory::new();
    while let Some(next) = robot.next_item() {
        let next = next.unwrap();
        let world_from_robot = next.truth.unwrap().world_from_robot.to_rigid3();
        let world_from_camera = world_from_robot * next.frame.robot_from_camera;
        truth.push(CameraPose { at: next.frame.at, world_from_camera }).unwrap();
        let slam =
            slam.get_or_insert_with(|| Slam::new(&next.frame.camera, &SlamConfig::default(), 1).unwrap());
        let image = GrayImage::from_rgb(&next.frame.image);
        slam.add_frame_of_robot(next.frame.at, image, next.frame.odom_from_camera()).unwrap();
    }
    let mut slam = slam.unwrap();
    slam.finish();
    assert_eq!(slam.map().maps().len(), 1);
    let mut estimate = CameraTrajectory::new();
    let poses = slam.trajectory();
    for pose in &poses {
        estimate.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera }).unwrap();
    }
    let num_seen = poses.iter().filter(|pose| !pose.is_carried).count();
    assert!(num_seen > 350, "{num_seen} of {}", poses.len());
    let error = absolute_error(&associate(&truth, &estimate, 0.001), Alignment::Similarity).unwrap();
    let by_odometry = slam.metric_scale(slam.map().maps()[0]).unwrap();
    assert!(
        (by_odometry.units_per_meter - 1.0).abs() < 1e-6 && by_odometry.deviation < 0.05,
        "{by_odometry:?}"
    );
    // Over three meters of way, with poses that are off by eight centimeters, truth and map tell their ratio to a tenth.
    assert!((error.similarity.scale - 1.0).abs() < 0.1, "{}", error.similarity.scale);
    assert!(error.statistics.rmse < 0.15, "{} m", error.statistics.rmse);
}
