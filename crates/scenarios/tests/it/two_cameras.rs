//! Robots with two cameras, as the Nao: one in the forehead, one in the mouth that sees the ground before the feet.

use std::f64::consts::PI;

use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    SourceFrame,
    geom::{CameraFrame, PlanarPose, Rigid3},
};
use visloc_locate::{LOCALIZED_RELIABILITY, Pipeline};
use visloc_scenarios::collect;
use visloc_sim::{FurtherCamera, HeadMount, Scenario, Simulation};
use visloc_world::Map;

/// A tour of a Nao with both cameras; the lower one looks so much farther down than it reports, degrees.
fn tour(name: &str, seed: u64, lower_pitch_deg: f64) -> (Map, Vec<SourceFrame>) {
    let mut scenario = Scenario::load(name).unwrap();
    scenario.frames_per_sec = 15.0;
    scenario.robot.mount = HeadMount::NaoTopV4;
    let camera = scenario.camera.clone();
    scenario.more_cameras =
        vec![FurtherCamera { mount: HeadMount::NaoBottomV4, camera, ..FurtherCamera::default() }];
    let simulation = Simulation::new(&scenario, seed).unwrap().with_threads(2);
    let map = simulation.map().clone();
    let mut frames = collect(&mut simulation.with_num_frames(300)).unwrap();
    let up = Rotation3::from_scaled_axis(Vector3::x() * lower_pitch_deg.to_radians());
    let up = Rigid3::<CameraFrame, CameraFrame>::new(up, Vector3::zeros());
    for frame in frames.iter_mut().filter(|frame| frame.frame.camera_index == 1) {
        frame.frame.robot_from_camera = frame.frame.robot_from_camera * up;
    }
    (map, frames)
}

/// How a run went.
#[derive(Debug)]
struct Run {
    localized_after_secs: Option<f64>,
    mean_error_m: f64,
}

fn run(map: &Map, frames: &[SourceFrame], seed: u64) -> (Run, Pipeline) {
    let mut pipeline = Pipeline::builder(map).seed(seed).build().unwrap();
    let (mut errors_m, mut first) = (Vec::new(), None);
    for frame in frames {
        let estimate = pipeline.step(&frame.frame).unwrap();
        let truth = frame.truth.unwrap().world_from_robot;
        let mirrored = PlanarPose::new(-truth.x_m, -truth.y_m, truth.yaw_rad + PI);
        let found = estimate.world_from_robot;
        let error_m = found.distance_m(&truth).min(found.distance_m(&mirrored));
        if estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY {
            first = first.or(Some(frame.frame.at));
            errors_m.push(error_m);
        }
    }
    let mean_error_m = errors_m.iter().sum::<f64>() / errors_m.len() as f64;
    let localized_after_secs = first.map(|first| first.secs_since(frames[0].frame.at));
    (Run { localized_after_secs, mean_error_m }, pipeline)
}

#[test]
fn both_cameras_together_follow_to_centimeters() {
    for name in ["tour", "tour-2024"] {
        let (map, frames) = tour(name, 1, 0.0);
        let (both, _) = run(&map, &frames, 1);
        assert!(both.localized_after_secs.is_some() && both.mean_error_m < 0.03, "{name}: {both:?}");
    }
}

/// Two fields, twelve seeds, since a single claim comes seconds sooner or later by chance: with both cameras the robot is on average
/// found at least as soon and followed at least as exactly as with the upper one.
#[test]
#[ignore = "twenty-four tours take a minute"]
fn both_cameras_together_are_at_least_as_good_as_one() {
    let (mut sum_of_one, mut sum_of_both) = ((0.0, 0.0), (0.0, 0.0));
    for (name, seed) in
        ["tour", "tour-2024"].into_iter().flat_map(|name| (1..=12).map(move |seed| (name, seed)))
    {
        let (map, frames) = tour(name, seed, 0.0);
        let upper: Vec<_> = frames.iter().filter(|frame| frame.frame.camera_index == 0).cloned().collect();
        let (one, _) = run(&map, &upper, seed);
        let (both, _) = run(&map, &frames, seed);
        assert!(both.mean_error_m < 0.03, "{name}, seed {seed}: {one:?}, {both:?}");
        for (sum, run) in [(&mut sum_of_one, one), (&mut sum_of_both, both)] {
            *sum = (sum.0 + run.localized_after_secs.unwrap(), sum.1 + run.mean_error_m);
        }
    }
    let what = format!("both cameras: {sum_of_both:?} s and m, one: {sum_of_one:?}");
    assert!(sum_of_both.0 <= sum_of_one.0 && sum_of_both.1 <= sum_of_one.1, "{what}");
}

/// The lower camera looks 1.5 degrees farther down than it reports: that is found for it and not for the other one.
#[test]
fn a_camera_that_is_bolted_on_wrong_is_told_from_the_other() {
    for seed in 1..=3 {
        let (map, frames) = tour("tour", seed, 1.5);
        let (outcome, pipeline) = run(&map, &frames, seed);
        let [upper, lower] = [0, 1].map(|camera| pipeline.localizer().camera_error_of(camera).unwrap());
        assert!(outcome.mean_error_m < 0.06 && upper.is_confirmed && lower.is_confirmed, "{outcome:?}");
        for (found, expected) in [(upper.pitch_down_deg, 0.0), (lower.pitch_down_deg, 1.5)] {
            let off_deg = (found.mean - expected).abs();
            assert!(off_deg < 0.7 && off_deg < 3.0 * found.sigma, "seed {seed}: {upper:?}, {lower:?}");
        }
        assert!(pipeline.localizer().camera_error_of(2).is_none(), "there is no third one");
    }
}

/// The first camera sees the same whether there are others or not, and which number the only camera has changes no bit.
#[test]
fn one_camera_is_as_before() {
    let (map, frames) = tour("tour-2024", 5, 0.0);
    let mut alone = Scenario::load("tour-2024").unwrap();
    (alone.frames_per_sec, alone.robot.mount) = (15.0, HeadMount::NaoTopV4);
    let alone = collect(&mut Simulation::new(&alone, 5).unwrap().with_num_frames(60)).unwrap();
    let upper = frames.iter().filter(|frame| frame.frame.camera_index == 0);
    let mut pipelines = [0, 1].map(|_| Pipeline::builder(&map).seed(5).build().unwrap());
    for (frame, same) in upper.zip(&alone) {
        assert_eq!(frame.frame.image.data(), same.frame.image.data());
        let fifth = frame.frame.clone().of_camera(5);
        let [first, fifth] =
            [(0, &frame.frame), (1, &fifth)].map(|(i, frame)| pipelines[i].step(frame).unwrap().clone());
        assert_eq!(first.world_from_robot, fifth.world_from_robot);
        assert_eq!(first.reliability.to_bits(), fifth.reliability.to_bits());
    }
    let [of_first, of_fifth] = [(0, 0), (1, 5)].map(|(i, of)| pipelines[i].localizer().camera_error_of(of));
    assert_eq!(of_first, of_fifth);
}
