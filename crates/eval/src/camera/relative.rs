//! Relative pose error.

use nalgebra::Vector3;

use super::{PosePair, Similarity};

/// Errors of motions between pairs a fixed number of pairs apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeError {
    /// Root of the mean square of the translation's error, meters.
    pub translation_rmse: f64,
    /// Root of the mean square of the rotation's error, radians.
    pub rotation_rmse_rad: f64,
}

/// Error of the motions from each pair to the one `delta` later, after the estimate has been scaled. `None` with too few
/// pairs.
///
/// Source: Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", 2012.
#[must_use]
pub fn relative_error(pairs: &[PosePair], delta: usize, similarity: &Similarity) -> Option<RelativeError> {
    let (mut translation, mut rotation, mut n) = (0.0, 0.0, 0.0);
    for (a, b) in pairs.iter().zip(pairs.iter().skip(delta.max(1))) {
        let truth = a.truth.world_from_camera.inverse() * b.truth.world_from_camera;
        let estimate = a.estimate.world_from_camera.inverse() * b.estimate.world_from_camera;
        let turn = truth.rotation().transpose() * estimate.rotation();
        // From the antisymmetric part: the trace alone cannot tell small angles.
        let sine = 0.5
            * Vector3::new(
                turn[(2, 1)] - turn[(1, 2)],
                turn[(0, 2)] - turn[(2, 0)],
                turn[(1, 0)] - turn[(0, 1)],
            )
            .norm();
        let angle = sine.atan2(0.5 * (turn.trace() - 1.0));
        rotation += angle * angle;
        translation += (estimate.translation() * similarity.scale - truth.translation()).norm_squared();
        n += 1.0;
    }
    (n > 0.0).then(|| RelativeError {
        translation_rmse: f64::sqrt(translation / n),
        rotation_rmse_rad: f64::sqrt(rotation / n),
    })
}
