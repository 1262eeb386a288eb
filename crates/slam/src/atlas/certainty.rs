//! How sure the edges of a pose graph are, where several kinds of them have to be weighed.

use nalgebra::{SMatrix, SVector};

use super::{PoseGraphEdge, Similarity};
use crate::map::Crossing;

/// Standard deviation of the turn between keyframes that share landmarks, radians, and of the shift, share of the depth of the scene. This and
/// what follows is from three runs of a rendered walk through corridors and rooms against the truth: along the
/// corridors a second's drift was 0.05 degrees and 0.2 % of the scale over four keyframes, in quick turns 0.45 degrees and up to 5 % over
/// fifteen. About 60 edges lead over each place, so one is eight times less sure than all.
const TURN_SIGMA: f64 = 0.0035;
/// The same of the logarithm of the scale.
const SCALE_SIGMA: f64 = 0.008;
/// Turn between two keyframes from which on the standard deviation of the turn grows with it, radians: what comes into view has been seen from few places.
const TURN_GROWS: f64 = 0.026;
/// Turn from which on that of the scale grows.
const SCALE_GROWS: f64 = 0.0087;
/// Standard deviation of the scale of a keyframe that is found at an earlier place: eight ratios of depths or more, each good to some percent.
const FOUND_SCALE_SIGMA: f64 = 0.01;

type Matrix7 = SMatrix<f64, 7, 7>;

/// Whitening of what landmarks say of two keyframes that share them.
pub(super) fn of_shared(first_from_second: &Similarity) -> Matrix7 {
    let turn = crate::lie::rotation_vector(&first_from_second.rotation).norm();
    let grown = |sigma: f64, grows: f64| sigma * 1.0_f64.hypot(turn / grows);
    diagonal(grown(TURN_SIGMA, TURN_GROWS), grown(SCALE_SIGMA, SCALE_GROWS))
}

/// Whitening of where a keyframe was found at an earlier place.
pub(super) fn of_sighting() -> Matrix7 {
    diagonal(TURN_SIGMA, FOUND_SCALE_SIGMA)
}

fn diagonal(pose: f64, scale: f64) -> Matrix7 {
    Matrix7::from_diagonal(&SVector::from_fn(|i, _| 1.0 / if i < 6 { pose } else { scale }))
}

/// The edge of a frame that two parts of the map know, in a graph of this length. It says nothing of the scale.
pub(super) fn edge_across(
    crossing: &Crossing,
    (first, second): (usize, usize),
    length: f64,
) -> Option<PoseGraphEdge> {
    let whitening = crossing.covariance().try_inverse()?.cholesky()?.l().transpose();
    let mut weight = Matrix7::zeros();
    // An error begins with the turn, a covariance with the translation.
    weight.fixed_view_mut::<6, 3>(0, 0).copy_from(&whitening.fixed_columns::<3>(3));
    weight.fixed_view_mut::<6, 3>(0, 3).copy_from(&(whitening.fixed_columns::<3>(0) * length));
    Some(PoseGraphEdge {
        first,
        second,
        first_from_second: Similarity::of_pose(&crossing.after.camera_from_keyframe),
        at_first: Similarity::of_pose(&crossing.before.camera_from_keyframe),
        weight,
    })
}
