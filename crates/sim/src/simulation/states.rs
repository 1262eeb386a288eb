//! What robot and sensors do at every frame, except the pictures.

use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};
use rand::RngExt as _;
use visloc_core::{
    GroundContact, RngTree, Truth,
    geom::{CameraFrame, PlanarPose, Rigid3, Robot, World},
};

use crate::{
    render::CameraMotion,
    robot::{Body, Feet, MotionPlan, Odometry},
    scenario::Scenario,
};

/// One frame without its picture.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) secs: f64,
    pub(super) truth: Truth,
    pub(super) world_from_camera: Rigid3<World, CameraFrame>,
    pub(super) motion: CameraMotion,
    pub(super) gain: f32,
    pub(super) light_color: [f32; 3],
    pub(super) robot_from_camera: Rigid3<Robot, CameraFrame>,
    pub(super) odometry: PlanarPose,
    pub(super) ground_contact: GroundContact,
}

/// Everything that determines the states.
#[derive(Debug)]
pub(super) struct Carrier {
    plan: Arc<MotionPlan>,
    body: Body,
}

impl Carrier {
    pub(super) fn new(scenario: &Scenario, plan: Arc<MotionPlan>, random: &RngTree) -> Self {
        Self { plan, body: Body::new(&scenario.robot, random) }
    }

    fn world_from_camera(&self, secs: f64) -> Rigid3<World, CameraFrame> {
        let moment = self.plan.at(secs);
        let upright = moment.pose().to_rigid3();
        let lean = Rotation3::from_euler_angles(0.0, moment.lean_rad, 0.0);
        let leaning = Rigid3::<Robot, Robot>::new(lean, Vector3::new(0.0, 0.0, moment.height_m));
        upright * leaning * self.body.robot_from_camera(secs, moment.swing)
    }

    /// The states of all frames of a scenario.
    pub(super) fn states(&self, scenario: &Scenario, random: &RngTree) -> Vec<State> {
        let mut odometry = Odometry::new(&scenario.robot.odometry, random);
        let feet = Feet::new(&scenario.robot.feet, random);
        let drift = ExposureDrift::new(scenario, random);
        let half_shutter_secs = scenario.camera.shutter_secs / 2.0;
        let frame = |index: usize| {
            let secs = index as f64 / scenario.frames_per_sec;
            let moment = self.plan.at(secs);
            let light = scenario.light.at(secs);
            let true_mount = self.body.robot_from_camera(secs, moment.swing);
            let stride = (self.body.stride_rad(secs), moment.swing);
            State {
                secs,
                truth: Truth {
                    world_from_robot: moment.pose(),
                    // A robot being lifted or put down is off the ground although its feet nearly touch it.
                    height_m: if moment.activity.is_carried() { moment.height_m.max(0.001) } else { 0.0 },
                },
                world_from_camera: self.world_from_camera(secs),
                motion: CameraMotion::between(
                    &self.world_from_camera(secs - half_shutter_secs),
                    &self.world_from_camera(secs + half_shutter_secs),
                ),
                gain: drift.gain(secs) * light.share,
                light_color: light.color,
                robot_from_camera: self.body.reported(&true_mount, secs, index as u64),
                odometry: odometry.step(moment.pose(), moment.activity),
                ground_contact: GroundContact::Pressure(feet.pressure(moment.activity, stride, index as u64)),
            }
        };
        (0..scenario.num_frames()).map(frame).collect()
    }
}

/// Automatic exposure that hunts up and down slowly.
struct ExposureDrift {
    mean_stops: f64,
    /// Strength in stops, rate in radians per second, start.
    waves: [(f64, f64, f64); 3],
    /// Largest jump in stops, and where the random numbers of each come from.
    jumps: (f64, RngTree),
}

impl ExposureDrift {
    fn new(scenario: &Scenario, random: &RngTree) -> Self {
        let rng = &mut random.stream("exposure", 0);
        let strength = scenario.camera.exposure_drift_stops / 3.0_f64.sqrt();
        let waves = [0.17, 0.41, 0.93].map(|rate: f64| {
            (strength, rate * rng.random_range(0.8..1.2), rng.random_range(0.0..std::f64::consts::TAU))
        });
        let jumps = (scenario.camera.exposure_step_stops, *random);
        Self { mean_stops: scenario.camera.exposure_stops, waves, jumps }
    }

    fn gain(&self, secs: f64) -> f32 {
        let drift: f64 =
            self.waves.iter().map(|(stops, rate, start)| stops * (rate * secs + start).sin()).sum();
        (self.mean_stops + drift + self.jump(secs)).exp2() as f32
    }

    fn jump(&self, secs: f64) -> f64 {
        const PERIOD_SECS: f64 = 4.0;
        let (most, random) = &self.jumps;
        let rng = &mut random.stream("exposure-jump", (secs / PERIOD_SECS).max(0.0) as u64);
        most * rng.random_range(-1.0..=1.0)
    }
}
