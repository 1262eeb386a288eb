//! Poses in the ground plane.

use nalgebra::{Matrix3, Point2, Vector3};
use serde::{Deserialize, Serialize};

use crate::geom::{Odom, Rigid3, Robot, World, angle};

/// Pose of the robot in the ground plane, or the planar motion between two such poses. Plain data: it is the state of
/// a particle and lives in large arrays. As a transform it is `world_from_robot`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PlanarPose {
    /// Position along the x axis of the frame, meters.
    pub x_m: f64,
    /// Position along the y axis of the frame, meters.
    pub y_m: f64,
    /// Heading, counter-clockwise from the x axis, radians in (-pi, pi].
    pub yaw_rad: f64,
}

impl PlanarPose {
    /// A pose from its parts; the heading is wrapped to (-pi, pi].
    #[inline]
    pub fn new(x_m: f64, y_m: f64, yaw_rad: f64) -> Self {
        Self { x_m, y_m, yaw_rad: angle::wrap(yaw_rad) }
    }

    /// `a_from_b.compose(b_from_c)` is `a_from_c`.
    #[inline]
    #[must_use]
    pub fn compose(&self, other: &Self) -> Self {
        let point = self.transform(&Point2::new(other.x_m, other.y_m));
        Self::new(point.x, point.y, self.yaw_rad + other.yaw_rad)
    }

    /// `a_from_b.inverse()` is `b_from_a`.
    #[inline]
    #[must_use]
    pub fn inverse(&self) -> Self {
        let (sin, cos) = self.yaw_rad.sin_cos();
        Self::new(-cos * self.x_m - sin * self.y_m, sin * self.x_m - cos * self.y_m, -self.yaw_rad)
    }

    /// This pose seen from `origin`: `world_from_a.relative_to(world_from_b)` is `b_from_a`.
    #[inline]
    #[must_use]
    pub fn relative_to(&self, origin: &Self) -> Self {
        origin.inverse().compose(self)
    }

    /// Takes a point of the robot frame to the frame of the pose.
    #[inline]
    pub fn transform(&self, point: &Point2<f64>) -> Point2<f64> {
        let (sin, cos) = self.yaw_rad.sin_cos();
        Point2::new(self.x_m + cos * point.x - sin * point.y, self.y_m + sin * point.x + cos * point.y)
    }

    /// Position without heading.
    #[inline]
    pub fn position(&self) -> Point2<f64> {
        Point2::new(self.x_m, self.y_m)
    }

    /// Distance between the two positions, meters.
    #[inline]
    pub fn distance_m(&self, other: &Self) -> f64 {
        (self.x_m - other.x_m).hypot(self.y_m - other.y_m)
    }

    /// Absolute difference of the headings, radians in [0, pi].
    #[inline]
    pub fn heading_difference_rad(&self, other: &Self) -> f64 {
        angle::difference(self.yaw_rad, other.yaw_rad).abs()
    }

    /// Whether every part is a finite number.
    pub fn is_finite(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.yaw_rad.is_finite()
    }

    /// The same pose in space: z = 0, rotation about the vertical.
    pub fn to_rigid3(&self) -> Rigid3<World, Robot> {
        self.to_space()
    }

    /// The same for a pose of accumulated odometry.
    pub fn to_odom_from_robot(&self) -> Rigid3<Odom, Robot> {
        self.to_space()
    }

    fn to_space<F>(self) -> Rigid3<F, Robot> {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let rotation = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        Rigid3::from_matrix_unchecked(rotation, Vector3::new(self.x_m, self.y_m, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pose() -> impl Strategy<Value = PlanarPose> {
        (-5.0..5.0f64, -5.0..5.0f64, -3.1..3.1f64).prop_map(|(x, y, yaw)| PlanarPose::new(x, y, yaw))
    }

    #[test]
    fn composition_by_hand() {
        let quarter_turn_at_1_2 = PlanarPose::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
        let moved = quarter_turn_at_1_2.compose(&PlanarPose::new(1.0, 0.0, 0.0));
        assert!((moved.x_m - 1.0).abs() < 1e-12 && (moved.y_m - 3.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn inverse_undoes(a in pose()) {
            let identity = a.compose(&a.inverse());
            prop_assert!(identity.distance_m(&PlanarPose::default()) < 1e-9);
            prop_assert!(identity.heading_difference_rad(&PlanarPose::default()) < 1e-9);
        }

        #[test]
        fn relative_then_compose_returns(a in pose(), b in pose()) {
            let back = b.compose(&a.relative_to(&b));
            prop_assert!(back.distance_m(&a) < 1e-9 && back.heading_difference_rad(&a) < 1e-9);
        }

        #[test]
        fn agrees_with_rigid3(a in pose(), b in pose()) {
            let planar = a.transform(&b.position());
            let spatial = a.to_rigid3().transform(&nalgebra::Point3::new(b.x_m, b.y_m, 0.0));
            prop_assert!((planar.x - spatial.x).abs() < 1e-9 && (planar.y - spatial.y).abs() < 1e-9);
        }
    }
}
