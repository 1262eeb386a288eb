//! The pose of a camera from three points that it sees, without a first guess.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
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
) -> impl Iterator<Item = CameraFromWorld> + use<> {
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

/// Real roots of a polynomial of degree four, constant term first. By Ferrari's way to two polynomials of degree two, then Newton's.
fn roots(coefficients: &[f64; 5]) -> [Option<f64>; MOST_POSES] {
    let [a0, a1, a2, a3, leading] = *coefficients;
    let [a0, a1, a2, a3] = [a0, a1, a2, a3].map(|coefficient| coefficient / leading);
    if ![a0, a1, a2, a3].iter().all(|coefficient| coefficient.is_finite()) {
        return [None; MOST_POSES];
    }
    // Without the term of degree three, in y = x + a3 / 4.
    let shift = a3 / 4.0;
    let p = a2 - 6.0 * shift * shift;
    let q = a1 - 2.0 * a2 * shift + 8.0 * shift.powi(3);
    let r = a0 - a1 * shift + a2 * shift * shift - 3.0 * shift.powi(4);
    // y^4 + p y^2 + q y + r is (y^2 + s y + t) (y^2 - s y + u) with s^2 a root of the resolvent.
    let z = largest_root_of_cubic(2.0 * p, p * p - 4.0 * r, -q * q).max(0.0);
    let s = z.sqrt();
    let share = if s > 0.0 { q / s } else { 0.0 };
    let [t, u] = if s > 0.0 {
        [(p + z - share) / 2.0, (p + z + share) / 2.0]
    } else {
        let half = (p * p / 4.0 - r).max(0.0).sqrt();
        [p / 2.0 - half, p / 2.0 + half]
    };
    let [first, second] = roots_of_square(s, t);
    let [third, fourth] = roots_of_square(-s, u);
    let polished = |y: f64| {
        let mut x = y - shift;
        for _ in 0..NEWTON_STEPS {
            let value = (((x + a3) * x + a2) * x + a1) * x + a0;
            let slope = ((4.0 * x + 3.0 * a3) * x + 2.0 * a2) * x + a1;
            let step = value / slope;
            if step.is_finite() && step.abs() < x.abs() {
                x -= step;
            }
        }
        x
    };
    [first, second, third, fourth].map(|y| y.map(polished))
}

/// Steps that make up for what is lost by rounding.
const NEWTON_STEPS: usize = 2;

/// Real roots of y^2 + b y + c. A pair that is hardly complex is two equal roots.
fn roots_of_square(b: f64, c: f64) -> [Option<f64>; 2] {
    /// Imaginary part up to which a root is real, as a share of its size.
    const REAL: f64 = 1e-3;
    let discriminant = b * b / 4.0 - c;
    if discriminant < -REAL * REAL * c.abs() {
        return [None; 2];
    }
    let root = discriminant.max(0.0).sqrt();
    [Some(-b / 2.0 + root), Some(-b / 2.0 - root)]
}

/// The largest real root of z^3 + b z^2 + c z + d.
fn largest_root_of_cubic(b: f64, c: f64, d: f64) -> f64 {
    let shift = b / 3.0;
    let p = c - b * shift;
    let half_q = shift.powi(3) - shift * c / 2.0 + d / 2.0;
    let discriminant = half_q * half_q + (p / 3.0).powi(3);
    let mut z = if discriminant < 0.0 {
        let radius = (-p / 3.0).sqrt();
        let angle = (-half_q / radius.powi(3)).clamp(-1.0, 1.0).acos() / 3.0;
        2.0 * radius * angle.cos()
    } else {
        let root = discriminant.sqrt();
        let large = -(half_q + root.copysign(half_q));
        let first = large.cbrt();
        if first == 0.0 { 0.0 } else { first - p / (3.0 * first) }
    } - shift;
    for _ in 0..NEWTON_STEPS {
        let step = (((z + b) * z + c) * z + d) / ((3.0 * z + 2.0 * b) * z + c);
        if step.is_finite() && step.abs() < z.abs() {
            z -= step;
        }
    }
    z
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
