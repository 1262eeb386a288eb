//! Point symmetry of a field with white goals.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use visloc_core::geom::{PlanarPose, angle};

/// The pose from which the field looks the same.
pub fn mirrored(pose: &PlanarPose) -> PlanarPose {
    PlanarPose::new(-pose.x_m, -pose.y_m, angle::wrap(pose.yaw_rad + PI))
}

/// The covariance (x, y, heading) of a mirrored pose.
pub fn mirrored_covariance(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let turn = Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0));
    turn * covariance * turn
}

/// Whether the mirror image of a pose is nearer to the truth than the pose itself, one radian counting as one meter.
pub fn is_mirror_nearer(pose: &PlanarPose, truth: &PlanarPose) -> bool {
    let distance = |pose: &PlanarPose| pose.distance_m(truth) + pose.heading_difference_rad(truth);
    distance(&mirrored(pose)) < distance(pose)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirroring_twice_changes_nothing() {
        let pose = PlanarPose::new(1.0, -2.0, 2.5);
        let twice = mirrored(&mirrored(&pose));
        assert!(twice.distance_m(&pose) < 1e-12 && twice.heading_difference_rad(&pose) < 1e-12);
        assert!(is_mirror_nearer(&mirrored(&pose), &pose) && !is_mirror_nearer(&pose, &pose));
        let covariance = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 0.1);
        let mirrored = mirrored_covariance(&covariance);
        assert_eq!((mirrored[(0, 1)], mirrored[(0, 2)], mirrored[(2, 2)]), (1.0, -0.5, 0.1));
    }
}
