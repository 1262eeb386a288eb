//! Observation models: how well a pose explains an image.

pub mod field;

use visloc_base::Rng;
use visloc_geom::PlanarPose;
use visloc_vision::Percept;

use crate::Region;

/// How well poses explain a percept. A localizer conditions the model on a percept once and then weighs many poses.
///
/// Laws: [`ObservationModel::likelihood`] is pure, lies in [0, 1], and is 1 for a pose that explains every pixel.
pub trait ObservationModel: Send {
    /// Prepares to weigh poses against this percept.
    fn condition_on(&mut self, percept: &Percept);

    /// Whether the percept says anything about the pose at all. Without evidence every pose has the same likelihood.
    fn has_evidence(&self) -> bool;

    /// Likelihood of the percept if the robot is at this pose, 0 to 1.
    fn likelihood(&self, world_from_robot: &PlanarPose) -> f64;

    /// Where the robot can be.
    fn region(&self) -> Region;

    /// Distance at which two poses share nothing, meters: a jump this far makes an estimate worthless.
    fn max_jump_m(&self) -> f64;

    /// A random pose that agrees with some part of the percept; anywhere if nothing narrows it down. After "sensor
    /// resetting", Lenser and Veloso, 2000.
    fn propose(&self, rng: &mut Rng) -> PlanarPose;

    /// A heading at this position that agrees with some part of the percept; any heading if nothing narrows it down.
    fn propose_heading(&self, x_m: f64, y_m: f64, rng: &mut Rng) -> f64;
}
