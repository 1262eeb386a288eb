//! What is known about the pose before anything is seen: it chooses between mirrored poses.

use visloc_core::geom::PlanarPose;

use crate::{StartPrior, observation::features::FeatureModel};

/// How sure a prior makes one of two mirrored poses, and having been near one of them last.
const SURE: f64 = 0.99;
const LIKELY: f64 = 0.9;
/// So near is where the robot was last.
const NEAR_LAST_M: f64 = 1.0;
const NEAR_LAST_RAD: f64 = 1.0;
/// Error of the odometry, as a share of the way.
const DRIFT: f64 = 0.1;

/// A prior, and how the robot has moved since it held.
#[derive(Debug, Clone)]
pub(super) struct Known {
    prior: StartPrior,
    /// The robot seen from where it was when the prior held.
    start_from_robot: PlanarPose,
    way_m: f64,
    /// Where the last established track was.
    last_pose: Option<PlanarPose>,
}

impl Known {
    /// Of a robot that is where the prior says.
    pub fn new(prior: StartPrior) -> Self {
        Self { prior, start_from_robot: PlanarPose::default(), way_m: 0.0, last_pose: None }
    }

    /// The robot was carried: where it was last says nothing any more. A prior may have been given for where it is put
    /// down, so that stays.
    pub fn forget_last(&mut self) {
        self.last_pose = None;
    }

    /// Takes in the motion since the last image, as the odometry has it.
    pub fn move_by(&mut self, motion: &PlanarPose) {
        self.start_from_robot = self.start_from_robot.compose(motion);
        self.way_m += motion.x_m.hypot(motion.y_m);
    }

    /// The robot seen from where it was in the first image, as the odometry has it.
    pub fn start_from_robot(&self) -> &PlanarPose {
        &self.start_from_robot
    }

    /// A track is established: it knows better from now on.
    pub fn establish(&mut self, pose: PlanarPose) {
        self.prior = StartPrior::Uniform;
        self.last_pose = Some(pose);
    }

    /// How far off the place where the prior held is, if the pose now is off by `spread_m`, meters.
    pub fn spread_m(&self, spread_m: f64) -> f64 {
        spread_m.hypot(DRIFT * self.way_m)
    }

    /// Probability of a pose beside its mirrored one if the prior tells them apart.
    pub fn share_by_prior(&self, model: &dyn FeatureModel, pose: &PlanarPose) -> Option<f64> {
        let mirrored = model.mirrored(pose)?;
        let allows = |pose: &PlanarPose| self.prior.allows(&pose.compose(&self.start_from_robot.inverse()));
        match (allows(pose), allows(&mirrored)) {
            (true, false) => Some(SURE),
            (false, true) => Some(1.0 - SURE),
            _ => None,
        }
    }

    /// Probability of a pose beside its mirrored one: the prior decides, then where the robot was last.
    pub fn share(&self, model: &dyn FeatureModel, pose: &PlanarPose) -> f64 {
        let Some(mirrored) = model.mirrored(pose) else { return 1.0 };
        if let Some(share) = self.share_by_prior(model, pose) {
            return share;
        }
        let is_near_last = |pose: &PlanarPose| {
            self.last_pose.is_some_and(|last| {
                pose.distance_m(&last) < NEAR_LAST_M && pose.heading_difference_rad(&last) < NEAR_LAST_RAD
            })
        };
        match (is_near_last(pose), is_near_last(&mirrored)) {
            (true, false) => LIKELY,
            (false, true) => 1.0 - LIKELY,
            _ => 0.5,
        }
    }
}
