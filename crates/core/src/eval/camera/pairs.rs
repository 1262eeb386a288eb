//! Which pose of the truth belongs to which estimate.

use crate::{CameraPose, CameraTrajectory, median};

/// Poses of the same moment.
#[derive(Debug, Clone, Copy)]
pub struct PosePair {
    /// Where the camera was.
    pub truth: CameraPose,
    /// Where it was thought to be.
    pub estimate: CameraPose,
}

/// Pairs each pose of the trajectory that has fewer with the nearest pose of the other, if one lies within the tolerance,
/// as `evo` does: a truth at a higher rate is thinned out, and so is an estimate. Of two that are as near the earlier is
/// taken.
pub fn associate(
    truth: &CameraTrajectory,
    estimate: &CameraTrajectory,
    tolerance_secs: f64,
) -> Vec<PosePair> {
    if estimate.poses().len() > truth.poses().len() {
        let pair = |truth: &CameraPose| {
            let estimate = estimate.nearest(truth.at, tolerance_secs)?;
            Some(PosePair { truth: *truth, estimate: *estimate })
        };
        return truth.poses().iter().filter_map(pair).collect();
    }
    let pair = |estimate: &CameraPose| {
        let truth = truth.nearest(estimate.at, tolerance_secs)?;
        Some(PosePair { truth: *truth, estimate: *estimate })
    };
    estimate.poses().iter().filter_map(pair).collect()
}

/// Share of the truth's time for which there is an estimate, 0 to 1: the time between neighboring pairs counts unless it is
/// longer than three times the median of all such times. `None` if the truth has no duration.
pub fn coverage(truth: &CameraTrajectory, pairs: &[PosePair]) -> Option<f64> {
    let (first, last) = (truth.poses().first()?, truth.poses().last()?);
    let duration_secs = last.at.secs_since(first.at);
    if duration_secs <= 0.0 {
        return None;
    }
    let steps: Vec<f64> = pairs.windows(2).map(|p| p[1].truth.at.secs_since(p[0].truth.at)).collect();
    let longest = median(steps.iter().copied()).map_or(0.0, |usual| 3.0 * usual);
    let covered_secs: f64 = steps.iter().filter(|step| **step <= longest).sum();
    Some(covered_secs / duration_secs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Timestamp, geom::Rigid3};

    fn trajectory(secs: impl Iterator<Item = f64>) -> CameraTrajectory {
        let mut trajectory = CameraTrajectory::new();
        for s in secs {
            let pose = CameraPose { at: Timestamp::from_secs(s), world_from_camera: Rigid3::identity() };
            trajectory.push(pose).unwrap();
        }
        trajectory
    }

    #[test]
    fn the_shorter_trajectory_is_paired_with_the_longer() {
        let dense = trajectory((0..100).map(|i| f64::from(i) * 0.1));
        let sparse = trajectory((0..5).map(|i| f64::from(i) * 2.0 + 0.004));
        assert_eq!(associate(&dense, &sparse, 0.01).len(), 5);
        assert_eq!(associate(&sparse, &dense, 0.01).len(), 5);
        assert!(associate(&dense, &sparse, 0.001).is_empty());
    }

    #[test]
    fn gaps_are_not_covered() {
        let truth = trajectory((0..=100).map(|i| f64::from(i) * 0.1));
        let estimate = trajectory((0..=100).filter(|i| !(30..60).contains(i)).map(|i| f64::from(i) * 0.1));
        let share = coverage(&truth, &associate(&truth, &estimate, 0.01)).unwrap();
        assert!((share - 0.69).abs() < 1e-9, "{share}");
        let whole = coverage(&truth, &associate(&truth, &truth, 0.01)).unwrap();
        assert!((whole - 1.0).abs() < 1e-9, "{whole}");
        assert_eq!(coverage(&truth, &[]), Some(0.0));
        assert_eq!(coverage(&CameraTrajectory::new(), &[]), None);
    }
}
