//! Which estimate belongs to which truth.

use std::collections::BTreeMap;

use crate::{PlanarTrajectory, StampedPose, Timestamp, geom::PlanarPose};

/// What an algorithm says after a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimateSample {
    /// Stamp of the frame.
    pub at: Timestamp,
    /// Pose of the robot in the map.
    pub world_from_robot: PlanarPose,
    /// How much the algorithm trusts it, in [0, 1]; `None` if it does not say, which counts as full trust.
    pub reliability: Option<f64>,
}

/// Pairs of truth and estimate in order of time. Every truth is used once, by the estimate nearest to it in time within
/// the tolerance, the earlier of two equally near ones. Estimates that are not finite numbers are left out.
pub(crate) fn associate<'a>(
    truth: &PlanarTrajectory,
    estimate: &'a [EstimateSample],
    tolerance_secs: f64,
) -> Vec<(StampedPose, &'a EstimateSample)> {
    let mut pairs: BTreeMap<Timestamp, (StampedPose, &EstimateSample)> = BTreeMap::new();
    let mut in_order: Vec<_> = estimate.iter().filter(|sample| sample.world_from_robot.is_finite()).collect();
    in_order.sort_by_key(|sample| sample.at);
    for sample in in_order {
        let Some(pose) = truth.nearest(sample.at, tolerance_secs) else { continue };
        let distance_secs = |other: &EstimateSample| other.at.secs_since(pose.at).abs();
        let is_nearer =
            pairs.get(&pose.at).is_none_or(|(_, other)| distance_secs(sample) < distance_secs(other));
        if is_nearer {
            pairs.insert(pose.at, (*pose, sample));
        }
    }
    pairs.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(secs: f64) -> EstimateSample {
        EstimateSample {
            at: Timestamp::from_secs(secs),
            world_from_robot: PlanarPose::new(secs, 0.0, 0.0),
            reliability: None,
        }
    }

    #[test]
    fn nearest_within_tolerance_and_each_truth_once() {
        let mut truth = PlanarTrajectory::new();
        for secs in [1.0, 2.0, 3.0] {
            let at = Timestamp::from_secs(secs);
            truth.push(StampedPose { at, world_from_robot: PlanarPose::default(), height_m: 0.0 }).unwrap();
        }
        let mut lost = sample(2.0);
        lost.world_from_robot.x_m = f64::NAN;
        let estimate = [sample(0.99), sample(1.005), sample(2.03), lost, sample(3.01)];
        let pairs: Vec<_> = associate(&truth, &estimate, 0.02)
            .into_iter()
            .map(|(pose, sample)| (pose.at.secs(), sample.world_from_robot.x_m))
            .collect();
        assert_eq!(pairs, [(1.0, 1.005), (3.0, 3.01)]);
    }
}
