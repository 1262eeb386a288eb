//! Absolute trajectory error.

use super::{Alignment, PosePair, Similarity, align};

/// Distances between aligned and true positions, meters.
#[derive(Debug, Clone, PartialEq)]
pub struct AbsoluteError {
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub max: f64,
    /// Of each pair, in order.
    pub each: Vec<f64>,
    /// How the estimate was moved.
    pub similarity: Similarity,
}

/// Aligns and measures. `None` without an alignment.
#[must_use]
pub fn absolute_error(pairs: &[PosePair], alignment: Alignment) -> Option<AbsoluteError> {
    let similarity = align(pairs, alignment)?;
    let distance = |pair: &PosePair| {
        let moved = similarity.apply(pair.estimate.world_from_camera.translation());
        (moved.coords - pair.truth.world_from_camera.translation()).norm()
    };
    let each: Vec<f64> = pairs.iter().map(distance).collect();
    let n = each.len() as f64;
    let mut sorted = each.clone();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let median = if sorted.len() % 2 == 1 {
        sorted[middle]
    } else {
        0.5 * (sorted[middle.checked_sub(1)?] + sorted[middle])
    };
    Some(AbsoluteError {
        rmse: (each.iter().map(|d| d * d).sum::<f64>() / n).sqrt(),
        mean: each.iter().sum::<f64>() / n,
        median,
        max: sorted.last().copied()?,
        each,
        similarity,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};
    use visloc_base::{CameraPose, Timestamp};
    use visloc_geom::Rigid3;

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
        assert!(error.rmse < 1e-9 && (error.similarity.scale - 4.0).abs() < 1e-9, "{}", error.rmse);
        assert!(absolute_error(&pairs(), Alignment::Rigid).unwrap().rmse > 0.1);
        assert!(absolute_error(&pairs()[..2], Alignment::Rigid).is_none());
    }
}
