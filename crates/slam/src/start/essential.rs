//! The essential matrix.

use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};
use visloc_core::geom::Rigid3;

use super::{RayPair, TwoViewMotion};

/// Essential matrix of at least eight pairs by least squares; `None` if they do not determine it.
///
/// Source: Longuet-Higgins 1981; Hartley, "In defense of the eight-point algorithm", 1997. Calibrated rays have the scale of
/// order 1 that the normalization is for.
#[must_use]
pub fn fit_essential(pairs: &[RayPair]) -> Option<Matrix3<f64>> {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for RayPair { first: a, second: b, .. } in pairs {
        let row = SMatrix::<f64, 1, 9>::from_row_slice(&[
            b.x * a.x,
            b.x * a.y,
            b.x,
            b.y * a.x,
            b.y * a.y,
            b.y,
            a.x,
            a.y,
            1.0,
        ]);
        normal += row.transpose() * row;
    }
    let matrix = least_eigenvector(&normal)?;
    let svd = matrix.svd(true, true);
    let middle = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0));
    Some(svd.u? * middle * svd.v_t?)
}

/// The 3 x 3 matrix (row by row) that a symmetric 9 x 9 matrix shrinks most.
pub(super) fn least_eigenvector(normal: &SMatrix<f64, 9, 9>) -> Option<Matrix3<f64>> {
    if !normal.iter().all(|v| v.is_finite()) {
        return None;
    }
    let eigen = normal.symmetric_eigen();
    let column = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    Some(Matrix3::from_row_slice(column.as_slice()))
}

/// The four motions of an essential matrix.
///
/// Source: Hartley and Zisserman, "Multiple view geometry", 2nd edition, result 9.19.
#[must_use]
pub fn decompose_essential(essential: &Matrix3<f64>) -> Vec<TwoViewMotion> {
    let svd = essential.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Vec::new() };
    let w = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let proper =
        |r: Matrix3<f64>| Rotation3::from_matrix_unchecked(if r.determinant() < 0.0 { -r } else { r });
    let turns = [proper(u * w * v_t), proper(u * w.transpose() * v_t)];
    // Singular values of a matrix that is not exact need not be sorted.
    let direction: Vector3<f64> = u.column(svd.singular_values.imin()).into_owned();
    let motions = turns.iter().flat_map(|turn| [1.0, -1.0].map(|sign| Rigid3::new(*turn, direction * sign)));
    motions.collect()
}
