//! The homography of a plane.

use nalgebra::{Matrix3, SMatrix, Vector3};
use visloc_core::geom::{Rigid3, nearest_rotation};

use super::{RayPair, TwoViewMotion, essential::least_eigenvector};
use crate::lie::skew;

/// Homography that takes rays (z = 1) of the first view to the second, of at least four pairs, by least squares.
///
/// Source: Hartley and Zisserman, "Multiple view geometry", 2nd edition, algorithm 4.1.
#[must_use]
pub fn fit_homography(pairs: &[RayPair]) -> Option<Matrix3<f64>> {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for RayPair { first: a, second: b, .. } in pairs {
        let rows = SMatrix::<f64, 2, 9>::from_row_slice(&[
            a.x,
            a.y,
            1.0,
            0.0,
            0.0,
            0.0,
            -b.x * a.x,
            -b.x * a.y,
            -b.x, //
            0.0,
            0.0,
            0.0,
            a.x,
            a.y,
            1.0,
            -b.y * a.x,
            -b.y * a.y,
            -b.y,
        ]);
        normal += rows.transpose() * rows;
    }
    least_eigenvector(&normal)
}

/// Motions of a homography, at most four; none for a pure rotation.
///
/// Source: Ma, Soatto, Kosecka and Sastry, "An invitation to 3-D vision", 2004, section 5.3.3 (the same solutions as Faugeras
/// and Lustman 1988).
#[must_use]
pub fn decompose_homography(homography: &Matrix3<f64>) -> Vec<TwoViewMotion> {
    let mut singular: Vec<f64> = homography.singular_values().iter().copied().collect();
    singular.sort_by(|a, b| b.total_cmp(a));
    let mut h = homography / singular[1].max(1e-12);
    if h.determinant() < 0.0 {
        h = -h;
    }
    let eigen = (h.transpose() * h).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let [s1, s3] = [eigen.eigenvalues[order[0]], eigen.eigenvalues[order[2]]];
    if (s1 - s3).is_nan() || s1 - s3 <= 1e-6 {
        return Vec::new();
    }
    let [v1, v2, v3] = order.map(|i| eigen.eigenvectors.column(i).into_owned());
    let (a, b) = ((1.0 - s3).max(0.0).sqrt(), (s1 - 1.0).max(0.0).sqrt());
    let mut motions = Vec::with_capacity(4);
    for side in [1.0, -1.0] {
        let u: Vector3<f64> = (v1 * a + v3 * (side * b)) / (s1 - s3).sqrt();
        let first = Matrix3::from_columns(&[v2, u, skew(&v2) * u]);
        let (hv, hu) = (h * v2, h * u);
        let second = Matrix3::from_columns(&[hv, hu, skew(&hv) * hu]);
        let rotation = nearest_rotation(&(second * first.transpose()));
        let normal = v2.cross(&u);
        let translation = (h - rotation.matrix()) * normal;
        if translation.norm() > 1e-9 {
            let direction = translation.normalize();
            motions.push(Rigid3::new(rotation, direction));
            motions.push(Rigid3::new(rotation, -direction));
        }
    }
    motions
}
