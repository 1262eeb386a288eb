//! Poses that look alike.

use std::f64::consts::PI;

use nalgebra::Matrix3;
use visloc_core::geom::PlanarPose;
use visloc_world::Map;

/// Which poses of a map look the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symmetry {
    /// None.
    None,
    /// Those turned by 180 degrees about the origin: a field with goals of one color.
    Point,
}

impl Symmetry {
    /// That of a map.
    pub fn of(map: &Map) -> Self {
        match map {
            Map::Field(field) if field.is_point_symmetric() => Self::Point,
            _ => Self::None,
        }
    }

    /// The pose that looks the same, if there is one.
    pub fn mirrored(self, pose: &PlanarPose) -> Option<PlanarPose> {
        match self {
            Self::None => None,
            Self::Point => Some(PlanarPose::new(-pose.x_m, -pose.y_m, pose.yaw_rad + PI)),
        }
    }
}

/// Covariance over (x, y, heading) of the mirrored pose: x and y change their signs, the heading does not.
pub(super) fn mirrored_covariance(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let turn = Matrix3::from_diagonal(&nalgebra::Vector3::new(-1.0, -1.0, 1.0));
    turn * covariance * turn
}
