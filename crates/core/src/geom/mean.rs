//! Weighted mean and covariance of planar poses.

use nalgebra::{Matrix3, Vector3};

use crate::geom::{PlanarPose, angle};

/// Mean and covariance of a set of weighted poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseStatistics {
    /// Weighted mean; the heading is averaged on the circle.
    pub mean: PlanarPose,
    /// Covariance over (x, y, heading), meters and radians, normalized by the weights of this set.
    pub covariance: Matrix3<f64>,
}

/// Weighted mean and covariance. Headings are averaged as unit vectors, so a set on both sides of +-pi has the mean a
/// person would give. `None` if the weights do not sum to a positive number.
pub fn weighted_pose_statistics<I>(weighted_poses: I) -> Option<PoseStatistics>
where
    I: Iterator<Item = (PlanarPose, f64)> + Clone,
{
    let (mut total, mut x, mut y, mut sin, mut cos) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (pose, weight) in weighted_poses.clone() {
        let (s, c) = pose.yaw_rad.sin_cos();
        total += weight;
        x += weight * pose.x_m;
        y += weight * pose.y_m;
        sin += weight * s;
        cos += weight * c;
    }
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mean = PlanarPose::new(x / total, y / total, sin.atan2(cos));
    let mut covariance = Matrix3::zeros();
    for (pose, weight) in weighted_poses {
        let d = Vector3::new(
            pose.x_m - mean.x_m,
            pose.y_m - mean.y_m,
            angle::difference(pose.yaw_rad, mean.yaw_rad),
        );
        covariance += d * d.transpose() * (weight / total);
    }
    Some(PoseStatistics { mean, covariance })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn headings_around_pi_average_to_pi() {
        let poses = [PlanarPose::new(0.0, 0.0, PI - 0.1), PlanarPose::new(2.0, 0.0, -PI + 0.1)];
        let statistics = weighted_pose_statistics(poses.iter().map(|p| (*p, 1.0))).unwrap();
        assert!(statistics.mean.heading_difference_rad(&PlanarPose::new(0.0, 0.0, PI)) < 1e-9);
        assert!((statistics.mean.x_m - 1.0).abs() < 1e-12);
        assert!((statistics.covariance[(0, 0)] - 1.0).abs() < 1e-12);
        assert!((statistics.covariance[(2, 2)] - 0.01).abs() < 1e-9);
    }

    #[test]
    fn weights_pull_the_mean() {
        let poses = [(PlanarPose::new(0.0, 0.0, 0.0), 3.0), (PlanarPose::new(4.0, 0.0, 0.0), 1.0)];
        let mean = weighted_pose_statistics(poses.iter().copied()).unwrap().mean;
        assert!((mean.x_m - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_weight_has_no_mean() {
        assert!(weighted_pose_statistics([(PlanarPose::default(), 0.0)].iter().copied()).is_none());
        assert!(weighted_pose_statistics(std::iter::empty::<(PlanarPose, f64)>()).is_none());
    }
}
