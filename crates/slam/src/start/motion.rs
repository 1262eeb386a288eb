//! Motion between two views from matched rays.

use nalgebra::{Matrix3, Point3, SMatrix, SVector, Vector3};
use visloc_core::geom::{CameraFrame, Rigid3};

use crate::lie::skew;

/// Motion between two views with a translation of length 1: `second_from_first`.
pub type TwoViewMotion = Rigid3<CameraFrame, CameraFrame>;

/// Signed Sampson distance of two rays (z = 1) from the epipolar constraint, on the plane z = 1.
///
/// Source: Hartley and Zisserman, "Multiple view geometry", 2nd edition, section 11.4.3.
#[inline]
#[must_use]
pub fn sampson(essential: &Matrix3<f64>, first: &Vector3<f64>, second: &Vector3<f64>) -> f64 {
    let line_in_second = essential * first;
    let line_in_first = essential.transpose() * second;
    let scale = line_in_second.xy().norm_squared() + line_in_first.xy().norm_squared();
    second.dot(&line_in_second) / scale.sqrt().max(1e-12)
}

/// The essential matrix of a motion.
#[inline]
#[must_use]
pub fn essential_of(motion: &TwoViewMotion) -> Matrix3<f64> {
    skew(motion.translation()) * motion.rotation()
}

/// Gauss-Newton on the Sampson distance over rotation and direction of translation, with Tukey's biweight cut off at
/// `cutoff` (on the plane z = 1).
#[must_use]
pub fn refine_motion(
    start: &TwoViewMotion,
    pairs: &[(Vector3<f64>, Vector3<f64>)],
    cutoff: f64,
    max_iterations: usize,
) -> TwoViewMotion {
    let mut motion = *start;
    for _ in 0..max_iterations {
        const STEP: f64 = 1e-6;
        let basis = tangent(motion.translation());
        let moved_by = |delta: &SVector<f64, 5>| apply(&motion, &basis, delta);
        let essential = essential_of(&motion);
        let shifted: [Matrix3<f64>; 5] = std::array::from_fn(|i| {
            let mut delta = SVector::<f64, 5>::zeros();
            delta[i] = STEP;
            essential_of(&moved_by(&delta))
        });
        let (mut hessian, mut gradient) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
        for (first, second) in pairs {
            let error = sampson(&essential, first, second);
            let ratio2 = (error / cutoff).powi(2);
            if ratio2 >= 1.0 {
                continue;
            }
            let jacobian =
                SVector::<f64, 5>::from_fn(|i, _| (sampson(&shifted[i], first, second) - error) / STEP);
            let weight = (1.0 - ratio2).powi(2);
            hessian += jacobian * jacobian.transpose() * weight;
            gradient -= jacobian * error * weight;
        }
        for i in 0..5 {
            hessian[(i, i)] = hessian[(i, i)] * (1.0 + 1e-6) + 1e-12;
        }
        let Some(step) = hessian.cholesky().map(|c| c.solve(&gradient)) else { break };
        if step.norm().is_nan() || step.norm() >= 0.5 {
            break;
        }
        motion = moved_by(&step);
        if step.norm() < 1e-8 {
            break;
        }
    }
    motion
}

/// Two directions at right angles to `t`.
fn tangent(t: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let other = if t.x.abs() < 0.6 * t.norm() { Vector3::x() } else { Vector3::y() };
    let a = t.cross(&other).normalize();
    (a, t.cross(&a).normalize())
}

fn apply(
    motion: &TwoViewMotion,
    basis: &(Vector3<f64>, Vector3<f64>),
    delta: &SVector<f64, 5>,
) -> TwoViewMotion {
    let turn = nalgebra::Rotation3::from_scaled_axis(Vector3::new(delta[0], delta[1], delta[2]));
    let rotation = turn * nalgebra::Rotation3::from_matrix_unchecked(*motion.rotation());
    let direction = (motion.translation() + basis.0 * delta[3] + basis.1 * delta[4]).normalize();
    Rigid3::new(rotation, direction)
}

/// Triangulated pairs in front of both cameras, in the first camera, baseline 1; `None` for the others.
#[must_use]
pub fn triangulate_pairs(
    motion: &TwoViewMotion,
    pairs: &[(Vector3<f64>, Vector3<f64>)],
) -> Vec<Option<Point3<f64>>> {
    let point = |(first, second): &(Vector3<f64>, Vector3<f64>)| {
        crate::solve::triangulate(motion, first, second).map(|(depth, _)| Point3::from(first * depth))
    };
    pairs.iter().map(point).collect()
}
