//! What a localizer says about the pose.

use nalgebra::{Matrix3, Vector3};
use visloc_core::geom::PlanarPose;

use crate::{MotionConfig, PlanarMotion};

/// From this reliability on a robot counts as localized. Source: 2010 section 5.1.4.
pub const LOCALIZED_RELIABILITY: f64 = 0.6;
/// Below this reliability a robot does not know where it is.
pub(crate) const LOST_RELIABILITY: f64 = 0.3;

/// One place where the robot may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// The pose.
    pub world_from_robot: PlanarPose,
    /// Covariance over (x, y, heading), meters and radians.
    pub covariance: Matrix3<f64>,
    /// Share of the belief, 0 to 1; all hypotheses together have 1.
    pub probability: f64,
}

/// The answer of a localizer after one step.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The pose of the winning hypothesis.
    pub world_from_robot: PlanarPose,
    /// Its covariance over (x, y, heading), meters and radians.
    pub covariance: Matrix3<f64>,
    /// How far the pose can be trusted, 0 to 1; localized above [`LOCALIZED_RELIABILITY`].
    pub reliability: f64,
    /// The same on a map that looks alike from a mirrored pose, if that pose were as good an answer. Without such a
    /// symmetry, and from localizers that do not look for it, it equals the reliability.
    pub reliability_up_to_symmetry: f64,
    /// Likelihood of the last image at the pose, 0 to 1.
    pub likelihood: f64,
    /// All hypotheses, the most probable first.
    pub hypotheses: Vec<Hypothesis>,
}

impl Estimate {
    /// Knows nothing.
    pub fn unknown() -> Self {
        Self {
            world_from_robot: PlanarPose::default(),
            covariance: Matrix3::identity() * 100.0,
            reliability: 0.0,
            reliability_up_to_symmetry: 0.0,
            likelihood: 0.0,
            hypotheses: Vec::new(),
        }
    }

    /// Forgets everything but the last pose, which stays as the place where the robot was seen last.
    pub(crate) fn forget(&mut self) {
        let world_from_robot = self.world_from_robot;
        self.hypotheses.clear();
        *self =
            Self { world_from_robot, hypotheses: std::mem::take(&mut self.hypotheses), ..Self::unknown() };
    }

    /// Moves on with the robot: the poses, and the covariances with the noise of the motion.
    pub(crate) fn move_by(&mut self, motion: &PlanarMotion) {
        if self.hypotheses.is_empty() {
            // Nothing is known of the pose, so nothing gets more uncertain.
            self.world_from_robot = motion.apply(&self.world_from_robot);
            return;
        }
        let noise = variances(motion.position_noise_m, motion.heading_noise_rad);
        let hypotheses = self.hypotheses.iter_mut().map(|h| (&mut h.world_from_robot, &mut h.covariance));
        for (pose, covariance) in hypotheses.chain([(&mut self.world_from_robot, &mut self.covariance)]) {
            let moved = motion.apply(pose);
            // An error of the heading turns the motion.
            let mut change = Matrix3::identity();
            change[(0, 2)] = pose.y_m - moved.y_m;
            change[(1, 2)] = moved.x_m - pose.x_m;
            *covariance = change * *covariance * change.transpose() + noise;
            *pose = moved;
        }
    }

    /// Moves on by an image that shows nothing, so many seconds after the last one: beside the motion that the odometry tells, the robot may
    /// have been moved in a way that it does not notice. Returns how much the standard deviation of the position has grown, meters.
    pub(crate) fn go_blind(
        &mut self,
        motion: Option<&PlanarMotion>,
        secs: f64,
        config: &MotionConfig,
    ) -> f64 {
        let before_m = self.spread_m();
        if let Some(motion) = motion {
            self.move_by(motion);
        }
        if !self.hypotheses.is_empty() {
            let noise = variances(config.blind_noise_m, config.blind_noise_rad) * secs;
            self.covariance += noise;
            self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.covariance += noise);
        }
        (self.spread_m() - before_m).max(0.0)
    }

    /// Standard deviation of the position, meters.
    fn spread_m(&self) -> f64 {
        (self.covariance[(0, 0)] + self.covariance[(1, 1)]).max(0.0).sqrt()
    }

    /// Sets the reliability of a localizer that knows of no symmetry.
    pub(crate) fn set_reliability(&mut self, reliability: f64) {
        self.reliability = reliability;
        self.reliability_up_to_symmetry = reliability;
    }

    /// Whether the pose can be relied on.
    pub fn is_localized(&self) -> bool {
        self.reliability > LOCALIZED_RELIABILITY
    }

    /// Sorts the hypotheses and makes their probabilities sum to 1.
    pub(crate) fn normalize_hypotheses(&mut self) {
        let total: f64 = self.hypotheses.iter().map(|h| h.probability).sum();
        if total > 0.0 {
            for hypothesis in &mut self.hypotheses {
                hypothesis.probability /= total;
            }
        }
        self.hypotheses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    }
}

fn variances(position_noise_m: f64, heading_noise_rad: f64) -> Matrix3<f64> {
    let place = position_noise_m.powi(2);
    Matrix3::from_diagonal(&Vector3::new(place, place, heading_noise_rad.powi(2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_forgets_claims_nothing() {
        let mut estimate = Estimate {
            world_from_robot: PlanarPose::new(1.0, 2.0, 0.5),
            covariance: Matrix3::identity() * 1e-4,
            reliability: 0.9,
            reliability_up_to_symmetry: 0.9,
            likelihood: 0.95,
            hypotheses: Vec::new(),
        };
        estimate.forget();
        assert_eq!(estimate.world_from_robot, PlanarPose::new(1.0, 2.0, 0.5));
        assert!(
            estimate.covariance[(0, 0)] > 10.0 && estimate.likelihood == 0.0 && estimate.reliability == 0.0
        );
    }
}
