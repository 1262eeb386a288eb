//! A robot that stands sees one view again and again: it says that it knows its place if the view fits one place only.

use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use visloc_core::{
    RngTree, SourceFrame, gaussian,
    geom::{CameraFrame, Rigid3, nao::HeadAngles},
};
use visloc_locate::{LOCALIZED_RELIABILITY, Pipeline};
use visloc_sim::{LiveControls, LiveMotion, LiveSimulation, Scenario};
use visloc_world::Map;

const PLACES: u64 = 40;
const IMAGES: usize = 30;

/// Three seconds at a random place with a still head; the reported direction of the camera is wrong by 1.5 degrees of pitch.
fn images(place: u64) -> (Map, Vec<SourceFrame>) {
    let mut draws = RngTree::new(7).stream("standing", place);
    let scenario = Scenario { frames_per_sec: 10.0, ..Scenario::load("tour-2024").unwrap() };
    let mut simulation = LiveSimulation::new(&scenario, 100 + place).unwrap();
    let world_from_robot = simulation.random_pose(0).unwrap();
    let head =
        HeadAngles { yaw_rad: draws.random_range(-0.8..0.8), pitch_rad: draws.random_range(0.12..0.33) };
    let tilt = Vector3::new(gaussian(&mut draws, 1.5), 0.0, gaussian(&mut draws, 0.8)).map(f64::to_radians);
    let turn = Rigid3::<CameraFrame, CameraFrame>::new(Rotation3::from_scaled_axis(tilt), Vector3::zeros());
    let controls = LiveControls { head: Some(head), ..LiveControls::default() };
    let motion = LiveMotion::Held { world_from_robot, height_m: 0.0, is_felt: false };
    simulation.step(&LiveControls { motion, ..controls });
    let mut frames: Vec<_> = (0..IMAGES).map(|_| simulation.step(&controls)).collect();
    for frame in &mut frames {
        frame.frame.robot_from_camera = frame.frame.robot_from_camera * turn;
    }
    (simulation.map().clone(), frames)
}

/// Forty random places on a field with white goals: of those that are claimed, up to the mirror image, all are right, and at least a fifth is
/// claimed: most views show too little.
#[test]
fn what_a_standing_robot_claims_is_right() {
    let (mut claimed, mut right) = (0, 0);
    for place in 0..PLACES {
        let (map, frames) = images(place);
        let mut pipeline = Pipeline::builder(&map).seed(place).build().unwrap();
        for frame in &frames {
            pipeline.step(&frame.frame).unwrap();
        }
        let estimate = pipeline.localizer().estimate();
        if estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY {
            let truth = frames[0].truth.unwrap().world_from_robot;
            let found = estimate.world_from_robot;
            let is_right = [1.0, -1.0]
                .iter()
                .any(|side| (side * found.x_m - truth.x_m).hypot(side * found.y_m - truth.y_m) < 0.3);
            claimed += 1;
            right += usize::from(is_right);
            assert!(estimate.reliability < 0.6, "of two mirrored places neither is sure");
        }
    }
    assert!(right == claimed && claimed >= 8, "{right} of {claimed} claims are right");
}
