//! The point where two rays meet.

use nalgebra::{Matrix2, Point3, Vector2, Vector3};
use visloc_core::geom::{CameraFrame, Rigid3};

/// Depths along z in both cameras of the point nearest to two rays (z = 1). `None` if the rays are nearly parallel or meet
/// behind a camera.
#[must_use]
pub fn triangulate(
    second_from_first: &Rigid3<CameraFrame, CameraFrame>,
    ray_in_first: &Vector3<f64>,
    ray_in_second: &Vector3<f64>,
) -> Option<(f64, f64)> {
    // depth1 * R * ray1 + t = depth2 * ray2, in the least-squares sense.
    let a = second_from_first.rotate(ray_in_first);
    let t = second_from_first.translation();
    let normal =
        Matrix2::new(a.dot(&a), -a.dot(ray_in_second), -a.dot(ray_in_second), ray_in_second.norm_squared());
    let scale = normal[(0, 0)] * normal[(1, 1)];
    if normal.determinant() < 1e-8 * scale {
        return None;
    }
    let depths = normal.try_inverse()? * Vector2::new(-a.dot(t), ray_in_second.dot(t));
    (depths.x > 0.0 && depths.y > 0.0).then_some((depths.x, depths.y))
}

/// Cosine of the angle under which two places see a point.
#[inline]
#[must_use]
pub fn cos_parallax(point: &Point3<f64>, first: &Point3<f64>, second: &Point3<f64>) -> f64 {
    let (a, b) = (point - first, point - second);
    a.dot(&b) / (a.norm() * b.norm()).max(1e-300)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector6};

    use super::*;

    #[test]
    fn meets_where_the_point_is() {
        let motion = crate::lie::exp::<CameraFrame>(&Vector6::new(0.3, -0.1, 0.05, 0.02, 0.1, -0.03));
        let point = Point3::new(0.4, -0.3, 2.5);
        let moved = motion.transform(&point);
        let (first, second) =
            triangulate(&motion, &(point.coords / point.z), &(moved.coords / moved.z)).unwrap();
        assert!((first - 2.5).abs() < 1e-9 && (second - moved.z).abs() < 1e-9);
    }

    #[test]
    fn parallel_and_diverging_rays_have_no_point() {
        let motion = Rigid3::new(Rotation3::identity(), Vector3::new(-0.2, 0.0, 0.0));
        let ahead = Vector3::new(0.0, 0.0, 1.0);
        assert!(triangulate(&motion, &ahead, &ahead).is_none());
        assert!(triangulate(&motion, &ahead, &Vector3::new(0.1, 0.0, 1.0)).is_none());
    }
}
