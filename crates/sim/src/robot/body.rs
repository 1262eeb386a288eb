//! Head and body: where the camera is relative to the footprint.

use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};
use rand::RngExt as _;
use visloc_core::{
    Rng, RngTree, gaussian,
    geom::{
        CameraFrame, Rigid3, Robot,
        nao::{self, HeadAngles, Torso},
    },
};

use super::path::phase;
use crate::scenario::RobotSetup;

/// The camera carrier.
#[derive(Debug)]
pub(crate) struct Body {
    setup: RobotSetup,
    random: RngTree,
    /// Where in their cycles the swings start, radians.
    phases_rad: [f64; 5],
    /// Slow errors of the angles (radians) and of the height (meters).
    biases: [SlowError; 3],
    height_bias: SlowError,
}

/// An error that comes and goes.
#[derive(Debug)]
struct SlowError {
    strength: f64,
    period_secs: f64,
    start_rad: f64,
}

impl SlowError {
    /// A random one of at most this strength.
    fn draw(most: f64, rng: &mut Rng) -> Self {
        let strength = most * rng.random_range(0.5..=1.0);
        Self { strength, period_secs: rng.random_range(12.0..50.0), start_rad: rng.random_range(0.0..TAU) }
    }

    fn at(&self, secs: f64) -> f64 {
        self.strength * (phase(secs, self.period_secs) + self.start_rad).sin()
    }
}

impl Body {
    pub(crate) fn new(setup: &RobotSetup, random: &RngTree) -> Self {
        let rng = &mut random.stream("body", 0);
        let bias_rad = setup.kinematics.bias_deg.to_radians();
        Self {
            setup: setup.clone(),
            random: *random,
            phases_rad: std::array::from_fn(|_| rng.random_range(0.0..TAU)),
            biases: std::array::from_fn(|_| SlowError::draw(bias_rad, rng)),
            height_bias: SlowError::draw(setup.kinematics.height_bias_m, rng),
        }
    }

    /// Where the head looks at a time since the start.
    pub(crate) fn head(&self, secs: f64) -> HeadAngles {
        let head = &self.setup.head;
        // The hyperbolic tangent lets the head rest near the ends of its pan.
        let pan = (2.0 * phase(secs, head.pan_period_secs).sin()).tanh() / 2.0_f64.tanh();
        let tilt = (phase(secs, head.tilt_period_secs) + self.phases_rad[0]).sin();
        HeadAngles {
            yaw_rad: head.pan_mean_deg.to_radians() + head.pan_deg.to_radians() * pan,
            pitch_rad: (head.tilt_deg + head.tilt_swing_deg * tilt).to_radians(),
        }
    }

    /// The phase of the walk, radians: one turn is two steps.
    pub(crate) fn stride_rad(&self, secs: f64) -> f64 {
        phase(secs, 2.0 / self.setup.gait.steps_per_sec) + self.phases_rad[1]
    }

    /// The true pose of the camera; `swing` is 0 while standing, 1 while walking.
    pub(crate) fn robot_from_camera(&self, secs: f64, swing: f64) -> Rigid3<Robot, CameraFrame> {
        self.robot_from_camera_with(&self.head(secs), secs, swing)
    }

    /// The same with a head that looks where it is told to.
    pub(crate) fn robot_from_camera_with(
        &self,
        head: &HeadAngles,
        secs: f64,
        swing: f64,
    ) -> Rigid3<Robot, CameraFrame> {
        let gait = &self.setup.gait;
        let stride = self.stride_rad(secs);
        let roll_rad = swing * gait.roll_deg.to_radians() * stride.sin();
        let pitch_rad = swing * gait.pitch_deg.to_radians() * (2.0 * stride + self.phases_rad[2]).sin();
        let shift = Vector3::new(
            0.4 * gait.bounce_m * (2.0 * stride + self.phases_rad[3]).sin(),
            gait.sway_m * (stride + 0.4).sin(),
            gait.bounce_m * (2.0 * stride + self.phases_rad[4]).sin(),
        ) * swing;
        let standing = match self.setup.mount.nao_camera() {
            Some(camera) => {
                let height_m = self.setup.neck_height_m - nao::NECK_OFFSET_Z_M;
                nao::robot_from_camera(&Torso { height_m, roll_rad, pitch_rad }, head, camera)
            }
            None => self.simple_mount(head, roll_rad, pitch_rad),
        };
        let rotation = Rotation3::from_matrix_unchecked(*standing.rotation());
        Rigid3::new(rotation, standing.translation() + shift)
    }

    fn simple_mount(&self, head: &HeadAngles, roll_rad: f64, pitch_rad: f64) -> Rigid3<Robot, CameraFrame> {
        let body = Rotation3::from_euler_angles(roll_rad, pitch_rad, 0.0);
        let body_from_head = body * Rotation3::from_euler_angles(0.0, head.pitch_rad, head.yaw_rad);
        let neck = Vector3::new(0.0, 0.0, self.setup.neck_height_m);
        let eye = Vector3::new(self.setup.eye_forward_m, 0.0, self.setup.eye_up_m);
        Rigid3::new(body_from_head * nao::body_from_optical(), body * neck + body_from_head * eye)
    }

    /// The pose that the joints report for frame `index`, given the true one.
    pub(crate) fn reported(
        &self,
        truth: &Rigid3<Robot, CameraFrame>,
        secs: f64,
        index: u64,
    ) -> Rigid3<Robot, CameraFrame> {
        let errors = &self.setup.kinematics;
        let rng = &mut self.random.stream("kinematics", index);
        let angles: [f64; 3] = std::array::from_fn(|axis| {
            let slow_rad = self.biases[axis].at(secs) - errors.mount_deg[axis].to_radians();
            slow_rad + gaussian(rng, errors.noise_deg.to_radians())
        });
        let mut shift: [f64; 3] = std::array::from_fn(|_| gaussian(rng, errors.noise_m));
        shift[2] += self.height_bias.at(secs);
        let wrong = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let rotation = Rotation3::from_matrix_unchecked(*truth.rotation());
        Rigid3::new(wrong * rotation, truth.translation() + Vector3::from(shift))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::HeadMount;

    fn body(mount: HeadMount) -> Body {
        Body::new(&RobotSetup { mount, ..RobotSetup::default() }, &RngTree::new(3))
    }

    #[test]
    fn head_stays_within_its_pattern_and_uses_it() {
        let body = body(HeadMount::Simple);
        let heads: Vec<_> = (0..2000).map(|i| body.head(f64::from(i) * 0.02)).collect();
        let most =
            |f: fn(&HeadAngles) -> f64| heads.iter().map(f).fold(f64::NEG_INFINITY, f64::max).to_degrees();
        assert!((54.0..55.01).contains(&most(|h| h.yaw_rad)));
        assert!((18.5..19.01).contains(&most(|h| h.pitch_rad)));
        assert!((-7.01..-6.5).contains(&most(|h| -h.pitch_rad)));
    }

    #[test]
    fn camera_is_at_eye_height_and_sways_only_while_walking() {
        let body = body(HeadMount::Simple);
        for i in 0..50 {
            let secs = f64::from(i) * 0.1;
            let standing = body.robot_from_camera(secs, 0.0);
            assert!((0.44..0.49).contains(&standing.translation().z));
            let axis = standing.rotate(&Vector3::z());
            let head = body.head(secs);
            assert!((axis.z + head.pitch_rad.sin()).abs() < 1e-9);
            let walking = body.robot_from_camera(secs, 1.0);
            assert!((walking.translation() - standing.translation()).norm() < 0.05);
        }
        let nao = self::body(HeadMount::NaoTopV4).robot_from_camera(0.0, 0.0);
        assert!((0.43..0.50).contains(&nao.translation().z));
    }

    #[test]
    fn reported_pose_has_the_configured_errors() {
        let body = body(HeadMount::Simple);
        let truth = body.robot_from_camera(1.0, 0.0);
        let errors: Vec<_> = (0..400)
            .map(|i| truth.inverse() * body.reported(&truth, f64::from(i as u32) / 30.0, i))
            .collect();
        let shift = errors.iter().map(|e| e.translation().norm_squared()).sum::<f64>() / 400.0;
        assert!((shift.sqrt() / (0.002 * 3.0_f64.sqrt()) - 1.0).abs() < 0.15);
        let worst = errors.iter().map(Rigid3::rotation_angle_rad).fold(0.0, f64::max).to_degrees();
        assert!((0.4..2.2).contains(&worst), "worst {worst}");
    }
}
