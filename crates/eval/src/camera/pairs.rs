//! Which pose of the truth belongs to which estimate.

use visloc_base::{CameraPose, CameraTrajectory};

/// Poses of the same moment.
#[derive(Debug, Clone, Copy)]
pub struct PosePair {
    /// Where the camera was.
    pub truth: CameraPose,
    /// Where it was thought to be.
    pub estimate: CameraPose,
}

/// Pairs each estimate with the nearest truth within a tolerance.
#[must_use]
pub fn associate(
    truth: &CameraTrajectory,
    estimate: &CameraTrajectory,
    tolerance_secs: f64,
) -> Vec<PosePair> {
    let pair = |estimate: &CameraPose| {
        let truth = truth.nearest(estimate.at, tolerance_secs)?;
        Some(PosePair { truth: *truth, estimate: *estimate })
    };
    estimate.poses().iter().filter_map(pair).collect()
}
