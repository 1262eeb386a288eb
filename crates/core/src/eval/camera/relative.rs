//! Relative pose error.

use nalgebra::{Matrix3, Vector3};

use super::{PosePair, Statistics};
use crate::geom::Similarity;

/// Errors of motions between pairs a fixed number of pairs apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeError {
    /// Root of the mean square of the translation's error, meters.
    pub translation_rmse: f64,
    /// Root of the mean square of the rotation's error, radians.
    pub rotation_rmse_rad: f64,
}

/// How far apart the two ends of a motion are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// So many pairs; at least 1 is used.
    Frames(usize),
    /// At least so much way of the estimate, after it has been scaled, meters.
    Meters(f64),
}

/// Which motions are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motions {
    /// One after the other: each begins where the one before ends.
    Consecutive,
    /// One from each pair; with [`Step::Meters`] to the pair whose way is nearest to the step, within a tenth of it.
    All,
}

/// Errors of many motions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RelativeErrors {
    /// First and last pair of each motion.
    pub motions: Vec<(usize, usize)>,
    /// Error of the translation of each, meters.
    pub translation_m: Vec<f64>,
    /// Error of the rotation of each, radians in [0, pi].
    pub rotation_rad: Vec<f64>,
}

/// Error of the motions from each pair to the one `delta` later, after the estimate has been scaled. `None` with too few
/// pairs.
///
/// Source: Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", 2012.
pub fn relative_error(pairs: &[PosePair], delta: usize, similarity: &Similarity) -> Option<RelativeError> {
    let errors = relative_errors(pairs, Step::Frames(delta), Motions::All, similarity);
    Some(RelativeError {
        translation_rmse: Statistics::of(&errors.translation_m)?.rmse,
        rotation_rmse_rad: Statistics::of(&errors.rotation_rad)?.rmse,
    })
}

/// Errors of motions, after the estimate has been scaled: E = (true motion)^-1 (estimated motion), its translation and its
/// angle. Empty if no two pairs are far enough apart.
///
/// Source: as [`relative_error`]; the choice of motions is that of `evo`.
pub fn relative_errors(
    pairs: &[PosePair],
    step: Step,
    motions: Motions,
    similarity: &Similarity,
) -> RelativeErrors {
    let motions = match step {
        Step::Frames(delta) => by_frames(pairs.len(), delta.max(1), motions),
        Step::Meters(delta_m) => by_meters(&ways_m(pairs, similarity), delta_m, motions),
    };
    let mut errors = RelativeErrors::default();
    for (i, j) in &motions {
        let (a, b) = (&pairs[*i], &pairs[*j]);
        let truth = a.truth.world_from_camera.inverse() * b.truth.world_from_camera;
        let estimate = a.estimate.world_from_camera.inverse() * b.estimate.world_from_camera;
        let missing = estimate.translation() * similarity.scale - truth.translation();
        errors.translation_m.push(missing.norm());
        errors.rotation_rad.push(angle_rad(&(truth.rotation().transpose() * estimate.rotation())));
    }
    errors.motions = motions;
    errors
}

/// Angle of a rotation, radians in [0, pi]; from its antisymmetric part too, since the trace alone cannot tell small angles.
pub(super) fn angle_rad(turn: &Matrix3<f64>) -> f64 {
    let axis =
        Vector3::new(turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)]);
    (0.5 * axis.norm()).atan2(0.5 * (turn.trace() - 1.0))
}

fn by_frames(n: usize, delta: usize, motions: Motions) -> Vec<(usize, usize)> {
    let stride = match motions {
        Motions::Consecutive => delta,
        Motions::All => 1,
    };
    (0..n).step_by(stride).map(|i| (i, i + delta)).filter(|(_, j)| *j < n).collect()
}

/// Way of the scaled estimate from the first pair to each, meters.
fn ways_m(pairs: &[PosePair], similarity: &Similarity) -> Vec<f64> {
    let position = |pair: &PosePair| pair.estimate.world_from_camera.translation() * similarity.scale;
    let mut ways = Vec::with_capacity(pairs.len());
    let mut way = 0.0;
    for (i, pair) in pairs.iter().enumerate() {
        if i > 0 {
            way += (position(pair) - position(&pairs[i - 1])).norm();
        }
        ways.push(way);
    }
    ways
}

fn by_meters(ways_m: &[f64], delta_m: f64, motions: Motions) -> Vec<(usize, usize)> {
    match motions {
        Motions::Consecutive => {
            let (mut from, mut found) = (0, Vec::new());
            for to in 1..ways_m.len() {
                if ways_m[to] - ways_m[from] >= delta_m {
                    found.push((from, to));
                    from = to;
                }
            }
            found
        }
        Motions::All => {
            let nearest = |i: usize| {
                let miss_m = |j: &usize| (ways_m[*j] - ways_m[i] - delta_m).abs();
                let rest = ways_m.get(i + 1..).filter(|rest| !rest.is_empty())?;
                let after = rest.partition_point(|way| way - ways_m[i] < delta_m);
                let after = (i + 1 + after).min(ways_m.len() - 1);
                let before = (after - 1).max(i + 1);
                let j = if miss_m(&before) <= miss_m(&after) { before } else { after };
                // While the camera stands, the first of the pairs at the same place counts.
                let j = i + 1 + rest.partition_point(|way| *way < ways_m[j]);
                (miss_m(&j) <= 0.1 * delta_m).then_some((i, j))
            };
            (0..ways_m.len()).filter_map(nearest).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_by_frames() {
        assert_eq!(by_frames(7, 2, Motions::Consecutive), [(0, 2), (2, 4), (4, 6)]);
        assert_eq!(by_frames(5, 3, Motions::All), [(0, 3), (1, 4)]);
        assert!(by_frames(2, 2, Motions::All).is_empty() && by_frames(0, 1, Motions::All).is_empty());
    }

    #[test]
    fn motions_by_meters() {
        let ways = [0.0, 0.4, 1.05, 1.2, 2.1, 2.2];
        assert_eq!(by_meters(&ways, 1.0, Motions::Consecutive), [(0, 2), (2, 4)]);
        assert_eq!(by_meters(&ways, 1.0, Motions::All), [(0, 2), (2, 4), (3, 5)]);
        assert_eq!(by_meters(&[0.0, 1.0, 1.0, 1.0], 1.0, Motions::All), [(0, 1)]);
        assert!(by_meters(&[], 1.0, Motions::All).is_empty());
    }
}
