//! Absolute trajectory error.

use nalgebra::Matrix3;

use super::{Alignment, PosePair, Statistics, align, relative::angle_rad};
use crate::geom::Similarity;

/// Distances between aligned and true positions, meters, and the rotations that are left.
#[derive(Debug, Clone, PartialEq)]
pub struct AbsoluteError {
    /// Of the distances.
    pub statistics: Statistics,
    /// Of each pair, in order.
    pub each: Vec<f64>,
    /// Angle between true and aligned orientation of each pair, radians in [0, pi].
    pub each_rotation_rad: Vec<f64>,
    /// How the estimate was moved.
    pub similarity: Similarity,
}

/// Aligns and measures. `None` without an alignment.
pub fn absolute_error(pairs: &[PosePair], alignment: Alignment) -> Option<AbsoluteError> {
    let similarity = align(pairs, alignment)?;
    let distance = |pair: &PosePair| {
        let moved = similarity.place(pair.estimate.world_from_camera.translation());
        (moved.coords - pair.truth.world_from_camera.translation()).norm()
    };
    let each: Vec<f64> = pairs.iter().map(distance).collect();
    let rotation = |pair: &PosePair| {
        let moved: Matrix3<f64> = similarity.rotation * pair.estimate.world_from_camera.rotation();
        angle_rad(&(pair.truth.world_from_camera.rotation().transpose() * moved))
    };
    let each_rotation_rad = pairs.iter().map(rotation).collect();
    Some(AbsoluteError { statistics: Statistics::of(&each)?, each, each_rotation_rad, similarity })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::{CameraPose, Timestamp, geom::Rigid3};

    fn pairs() -> Vec<PosePair> {
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -0.4, 0.9));
        (0..50)
            .map(|i| {
                let s = f64::from(i) * 0.1;
                let position = Vector3::new(s.cos(), s.sin(), 0.2 * s);
                let pose = |rotation, translation| CameraPose {
                    at: Timestamp::from_secs(s),
                    world_from_camera: Rigid3::new(rotation, translation),
                };
                let estimate = turn * position * 0.25 + Vector3::new(1.0, 2.0, 3.0);
                PosePair { truth: pose(Rotation3::identity(), position), estimate: pose(turn, estimate) }
            })
            .collect()
    }

    #[test]
    fn a_moved_copy_has_no_error_after_alignment() {
        let error = absolute_error(&pairs(), Alignment::Similarity).unwrap();
        assert!(
            error.statistics.rmse < 1e-9 && (error.similarity.scale - 4.0).abs() < 1e-9,
            "{}",
            error.statistics.rmse
        );
        assert!(error.each_rotation_rad.iter().all(|angle| *angle < 1e-9));
        assert!(absolute_error(&pairs(), Alignment::Rigid).unwrap().statistics.rmse > 0.1);
        assert!(absolute_error(&pairs()[..2], Alignment::Rigid).is_none());
    }

    #[test]
    fn without_alignment_every_difference_counts() {
        let error = absolute_error(&pairs(), Alignment::None).unwrap();
        assert!(error.each_rotation_rad.iter().all(|angle| (angle - 1.06_f64.sqrt()).abs() < 1e-9));
        assert!(error.statistics.mean > 1.0);
        assert!(absolute_error(&[], Alignment::None).is_none());
    }
}
