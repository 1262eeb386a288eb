//! The pose of a camera from three points that it sees, without a first guess.

use nalgebra::{Matrix3, Matrix4, Point3, Rotation3, Vector3};
use visloc_core::geom::Rigid3;

use crate::lie::CameraFromWorld;

/// Most poses from which three points look the same.
pub const MOST_POSES: usize = 4;

/// Up to four poses of a camera from which three points of the world are seen along three rays (of any length). None if the points are
/// on one line, or two rays are the same.
///
/// Source: Haralick, Lee, Ottenberg and Nölle, "Review and analysis of solutions of the three point perspective pose estimation
/// problem", 1994, the solution of Grunert: distances from the camera by a polynomial of degree four.
pub fn poses_from_three_points(
    points: &[Point3<f64>; 3],
    rays: &[Vector3<f64>; 3],
) -> impl Iterator<Item = CameraFromWorld> {
    let (points, rays) = (*points, rays.map(|ray| ray.normalize()));
    let world = frame_of_triangle(&points.map(|point| point.coords));
    distances(&points, &rays).into_iter().flatten().filter_map(move |[s1, s2, s3]| {
        let seen = [rays[0] * s1, rays[1] * s2, rays[2] * s3];
        let turn = frame_of_triangle(&seen)? * world?.transpose();
        let turn = Rotation3::from_matrix_unchecked(turn);
        Some(Rigid3::new(turn, seen[0] - turn * points[0].coords))
    })
}

/// Axes that are fixed to a triangle; `None` if its corners are on one line.
fn frame_of_triangle(corners: &[Vector3<f64>; 3]) -> Option<Matrix3<f64>> {
    let along = corners[1] - corners[0];
    let across = along.cross(&(corners[2] - corners[0]));
    let (x, z) = (along.try_normalize(0.0)?, across.try_normalize(1e-12 * along.norm_squared())?);
    Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
}

/// Distances of the three points from the camera, as many triples as there are.
fn distances(points: &[Point3<f64>; 3], rays: &[Vector3<f64>; 3]) -> [Option<[f64; 3]>; MOST_POSES] {
    let [a2, b2, c2] =
        [points[1] - points[2], points[0] - points[2], points[0] - points[1]].map(|edge| edge.norm_squared());
    let (alpha, beta, gamma) = (rays[1].dot(&rays[2]), rays[0].dot(&rays[2]), rays[0].dot(&rays[1]));
    // In the names of the source: v = s3 / s1, u = s2 / s1.
    let (p, q, r) = ((a2 - c2) / b2, (a2 + c2) / b2, c2 / b2);
    let coefficients = [
        (1.0 + p).powi(2) - 4.0 * a2 / b2 * gamma * gamma,
        4.0 * (-p * (1.0 + p) * beta + 2.0 * a2 / b2 * gamma * gamma * beta - (1.0 - q) * alpha * gamma),
        2.0 * (p * p - 1.0 + 2.0 * p * p * beta * beta + 2.0 * (1.0 - r) * alpha * alpha
            - 4.0 * q * alpha * beta * gamma
            + 2.0 * (1.0 - a2 / b2) * gamma * gamma),
        4.0 * (p * (1.0 - p) * beta - (1.0 - q) * alpha * gamma + 2.0 * r * alpha * alpha * beta),
        (p - 1.0).powi(2) - 4.0 * r * alpha * alpha,
    ];
    roots(&coefficients).map(|v| {
        let v = v.filter(|v| *v > 0.0)?;
        let u = ((p - 1.0) * v * v - 2.0 * p * beta * v + 1.0 + p) / (2.0 * (gamma - v * alpha));
        let s1 = (b2 / (1.0 + v * v - 2.0 * v * beta)).sqrt();
        (u > 0.0 && u.is_finite() && s1.is_finite()).then_some([s1, u * s1, v * s1])
    })
}

/// Real roots of a polynomial of degree four, constant term first.
fn roots(coefficients: &[f64; 5]) -> [Option<f64>; MOST_POSES] {
    /// Imaginary part up to which a root is real, as a share of its size: two equal roots come out as a pair that is hardly complex.
    const REAL: f64 = 1e-3;
    let leading = coefficients[4];
    if coefficients.iter().any(|coefficient| !(coefficient / leading).is_finite()) {
        return [None; MOST_POSES];
    }
    let mut companion = Matrix4::zeros();
    for i in 0..MOST_POSES {
        companion[(i, 3)] = -coefficients[i] / leading;
        if i > 0 {
            companion[(i, i - 1)] = 1.0;
        }
    }
    // Bounded in its steps: an eigenvalue problem that does not converge has no roots.
    let Some(schur) = companion.try_schur(f64::EPSILON, 100) else { return [None; MOST_POSES] };
    let values = schur.complex_eigenvalues();
    std::array::from_fn(|i| (values[i].im.abs() <= REAL * values[i].re.abs()).then_some(values[i].re))
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;
    use rand::RngExt;
    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn the_true_pose_is_among_them() {
        let mut rng = RngTree::new(5).stream("three points", 0);
        let mut num = |low: f64, high: f64| rng.random_range(low..high);
        let mut num_wrong = 0;
        for _ in 0..1000 {
            let turn = Rotation3::from_euler_angles(num(-3.0, 3.0), num(-1.5, 1.5), num(-3.0, 3.0));
            let truth: CameraFromWorld =
                Rigid3::new(turn, Vector3::new(num(-9.0, 9.0), num(-9.0, 9.0), num(-9.0, 9.0)));
            let rays: [Vector3<f64>; 3] =
                std::array::from_fn(|_| Vector3::new(num(-0.6, 0.6), num(-0.5, 0.5), 1.0));
            let points = rays.map(|ray| truth.inverse().transform(&Point3::from(ray * num(1.0, 8.0))));
            let error = poses_from_three_points(&points, &rays)
                .map(|pose| (pose * truth.inverse()).rotation_angle_rad())
                .fold(f64::INFINITY, f64::min);
            num_wrong += usize::from(error > 1e-4);
        }
        // Nearly equal roots, or three points nearly on a line, may cost one in a hundred.
        assert!(num_wrong <= 10, "{num_wrong} of 1000 are wrong");
    }

    #[test]
    fn points_on_a_line_have_no_pose() {
        let points = [0.0, 1.0, 2.0].map(|x| Point3::new(x, 0.0, 5.0));
        let rays = points.map(|point| point.coords);
        assert_eq!(poses_from_three_points(&points, &rays).count(), 0);
    }
}
