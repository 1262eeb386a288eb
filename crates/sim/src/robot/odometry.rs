//! Odometry with systematic and random errors.

use rand::RngExt as _;
use visloc_core::{Rng, RngTree, gaussian, geom::PlanarPose};

use super::plan::Activity;
use crate::scenario::OdometrySetup;

/// Integrates the true motion with errors.
#[derive(Debug)]
pub(crate) struct Odometry {
    setup: OdometrySetup,
    scales: [f64; 3],
    turn_bias_rad_per_m: f64,
    rng: Rng,
    odom_from_robot: PlanarPose,
    world_from_robot: Option<PlanarPose>,
}

impl Odometry {
    /// Draws the systematic errors of this run.
    pub(crate) fn new(setup: &OdometrySetup, random: &RngTree) -> Self {
        let mut rng = random.stream("odometry", 0);
        let [least, most] = setup.scale_error;
        let scales = std::array::from_fn(|_| {
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            1.0 + sign * rng.random_range(least..=most)
        });
        let turn_bias_rad_per_m = gaussian(&mut rng, setup.turn_bias_deg_per_m.to_radians());
        Self {
            setup: setup.clone(),
            scales,
            turn_bias_rad_per_m,
            rng,
            odom_from_robot: PlanarPose::default(),
            world_from_robot: None,
        }
    }

    /// The same with other errors from now on; what has been counted stays.
    pub(crate) fn with_setup(&self, setup: &OdometrySetup, random: &RngTree) -> Self {
        let drawn = Self::new(setup, random);
        Self { odom_from_robot: self.odom_from_robot, world_from_robot: self.world_from_robot, ..drawn }
    }

    /// Factors between true and reported motion: forward, sideways, turn.
    #[cfg(test)]
    fn scales(&self) -> [f64; 3] {
        self.scales
    }

    /// The accumulated odometry after the robot has come to a new true pose.
    pub(crate) fn step(&mut self, world_from_robot: PlanarPose, activity: Activity) -> PlanarPose {
        let before = self.world_from_robot.replace(world_from_robot);
        let truth = before.map_or(PlanarPose::default(), |before| world_from_robot.relative_to(&before));
        let motion = match activity {
            Activity::Standing | Activity::Walking => self.distorted(&truth),
            Activity::Lifted => PlanarPose::default(),
            // Marching on the spot: the feet report small steps to all sides.
            Activity::LiftedUnnoticed => PlanarPose::new(
                gaussian(&mut self.rng, 0.0006),
                gaussian(&mut self.rng, 0.0006),
                gaussian(&mut self.rng, 0.001),
            ),
        };
        self.odom_from_robot = self.odom_from_robot.compose(&motion);
        self.odom_from_robot
    }

    fn distorted(&mut self, truth: &PlanarPose) -> PlanarPose {
        let way_m = truth.x_m.hypot(truth.y_m);
        // Turning slips as well: 20 radians on the spot count as one meter.
        let effort = (way_m + 0.05 * truth.yaw_rad.abs()).sqrt();
        let noise_rad = self.setup.noise_deg.to_radians() * effort;
        PlanarPose::new(
            truth.x_m * self.scales[0] + gaussian(&mut self.rng, self.setup.noise_m * effort),
            truth.y_m * self.scales[1] + gaussian(&mut self.rng, self.setup.noise_m * effort),
            truth.yaw_rad * self.scales[2]
                + self.turn_bias_rad_per_m * way_m
                + gaussian(&mut self.rng, noise_rad),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drift_matches_the_drawn_errors() {
        for seed in 0..10 {
            let mut odometry = Odometry::new(&OdometrySetup::default(), &RngTree::new(seed));
            let [forward, _, turn] = odometry.scales();
            for scale in odometry.scales() {
                assert!((0.05..=0.10).contains(&(scale - 1.0).abs()), "scale {scale}");
            }
            odometry.turn_bias_rad_per_m = 0.0;
            let mut last = PlanarPose::default();
            for i in 0..=300 {
                last = odometry.step(PlanarPose::new(f64::from(i) * 0.01, 0.0, 0.0), Activity::Walking);
            }
            // 3 m: noise of 1 cm per root of meter, and 2 degrees of heading
            assert!((last.x_m - 3.0 * forward).abs() < 0.09, "{} for {forward}", last.x_m);
            let mut odometry = Odometry::new(&OdometrySetup::default(), &RngTree::new(seed));
            for i in 0..=300 {
                last = odometry.step(PlanarPose::new(0.0, 0.0, f64::from(i) * 0.01), Activity::Walking);
            }
            assert!((visloc_core::geom::angle::difference(last.yaw_rad, 3.0 * turn)).abs() < 0.04);
        }
    }

    #[test]
    fn odometry_does_not_follow_a_carry() {
        for (activity, reach) in [(Activity::Lifted, 0.0), (Activity::LiftedUnnoticed, 0.03)] {
            let mut odometry = Odometry::new(&OdometrySetup::default(), &RngTree::new(1));
            odometry.step(PlanarPose::default(), Activity::Standing);
            let mut last = PlanarPose::default();
            for i in 0..60 {
                last = odometry.step(PlanarPose::new(f64::from(i) * 0.05, 0.0, 1.0), activity);
            }
            assert!(last.distance_m(&PlanarPose::default()) <= reach, "{last:?}");
            let after = odometry.step(PlanarPose::new(2.95, 0.0, 1.0), Activity::Walking);
            assert!(after.distance_m(&last) < 1e-9, "standing after the carry adds nothing");
        }
    }
}
