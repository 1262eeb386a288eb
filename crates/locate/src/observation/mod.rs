//! Observation models: how well a pose explains an image.

mod edge;
pub mod features;
pub mod field;
pub mod office;
pub(crate) mod projection;

use nalgebra::Point2;
use visloc_core::{Rng, geom::PlanarPose};

use crate::{
    Region,
    vision::{FeatureKind, Percept},
};

/// A thing of one color that stands out as a whole: two posts with a bar on top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landmark {
    /// What it is in a percept.
    pub kind: FeatureKind,
    /// Feet of its posts, (x, y) of the world, meters.
    pub ends: [Point2<f64>; 2],
    /// Height of the bar's axis above the ground, meters.
    pub height_m: f64,
    /// Radius of posts and bar, meters.
    pub radius_m: f64,
}

/// How well poses explain a percept. A localizer conditions the model on a percept once and then weighs many poses.
///
/// Laws: [`ObservationModel::likelihood`] is pure, lies in [0, 1], and is 1 for a pose that explains every pixel. It may
/// be called from several threads at once.
pub trait ObservationModel: Send + Sync {
    /// Prepares to weigh poses against this percept.
    fn condition_on(&mut self, percept: &Percept);

    /// Whether the percept says anything about the pose at all. Without evidence every pose has the same likelihood.
    fn has_evidence(&self) -> bool;

    /// Likelihood of the percept if the robot is at this pose, 0 to 1.
    fn likelihood(&self, world_from_robot: &PlanarPose) -> f64;

    /// The likelihood if it is above `least`, which a model may know before it has worked it out.
    fn likelihood_above(&self, world_from_robot: &PlanarPose, least: f64) -> Option<f64> {
        Some(self.likelihood(world_from_robot)).filter(|likelihood| *likelihood > least)
    }

    /// Natural logarithm of the likelihood. A model that multiplies over many pixels gives it directly, since its
    /// likelihood may be too small for a number.
    fn log_likelihood(&self, world_from_robot: &PlanarPose) -> f64 {
        self.likelihood(world_from_robot).ln()
    }

    /// Log likelihoods of many poses, minus infinity outside the region. `out` is as long as the poses.
    fn log_likelihoods(&self, world_from_robot: &[PlanarPose], out: &mut [f64]) {
        let region = self.region();
        for (pose, out) in world_from_robot.iter().zip(out) {
            *out = if region.contains(pose) { self.log_likelihood(pose) } else { f64::NEG_INFINITY };
        }
    }

    /// The part of the world outside of which the robot cannot be.
    fn region(&self) -> Region;

    /// A random pose where the robot can be, with any heading.
    fn sample(&self, rng: &mut Rng) -> PlanarPose {
        self.region().sample(rng)
    }

    /// Distance at which two poses share nothing, meters: a jump this far makes an estimate worthless.
    fn max_jump_m(&self) -> f64;

    /// A random pose that agrees with some part of the percept; anywhere if nothing narrows it down. After "sensor
    /// resetting", Lenser and Veloso, 2000.
    fn propose(&self, rng: &mut Rng) -> PlanarPose;

    /// A heading at this position that agrees with some part of the percept; any heading if nothing narrows it down.
    fn propose_heading(&self, x_m: f64, y_m: f64, rng: &mut Rng) -> f64;

    /// Landmarks that can be told apart by their kind; none if the map has no such things.
    fn landmarks(&self) -> Vec<Landmark> {
        Vec::new()
    }
}
