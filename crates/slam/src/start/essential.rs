//! The essential matrix.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3};
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

/// Most steps of the inverse iteration; a sample that determines its matrix takes two.
const MOST_STEPS: usize = 50;

/// The 3 x 3 matrix (row by row) that a symmetric 9 x 9 matrix without negative eigenvalues shrinks most, by inverse iteration: Golub and
/// Van Loan, "Matrix computations", 4th edition, section 8.2.2. `None` of what is not finite.
pub(super) fn least_eigenvector(normal: &SMatrix<f64, 9, 9>) -> Option<Matrix3<f64>> {
    // A sample of the least size leaves an eigenvalue of zero, which rounding may make negative.
    let shift = 1e-13 * normal.trace();
    let shifted = (normal + SMatrix::identity() * shift).cholesky()?;
    let mut column = SVector::<f64, 9>::from_fn(|i, _| 1.0 + 0.1 * i as f64).normalize();
    for _ in 0..MOST_STEPS {
        let next = shifted.solve(&column).normalize();
        let turn2 = 1.0 - next.dot(&column).powi(2);
        column = next;
        if turn2 < 1e-14 {
            break;
        }
    }
    column.iter().all(|v| v.is_finite()).then(|| Matrix3::from_row_slice(column.as_slice()))
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

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn the_least_eigenvector_is_that_of_a_general_solver() {
        let mut rng = RngTree::new(4).stream("eigenvector", 0);
        for (num_rows, noise) in [(8, 1.0), (9, 0.1), (40, 0.1)] {
            // Rows at right angles to one vector, up to noise.
            let across = SVector::<f64, 9>::from_fn(|_, _| rng.random_range(-1.0..1.0)).normalize();
            let mut normal = SMatrix::<f64, 9, 9>::zeros();
            for _ in 0..num_rows {
                let row = SVector::<f64, 9>::from_fn(|_, _| rng.random_range(-1.0..1.0));
                let row = row - across * (row.dot(&across) * (1.0 - noise));
                normal += row * row.transpose();
            }
            let eigen = normal.symmetric_eigen();
            let expected = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
            let found = least_eigenvector(&normal).unwrap();
            let found = SVector::<f64, 9>::from_row_slice(found.transpose().as_slice());
            assert!(1.0 - found.dot(&expected).abs() < 1e-10, "{num_rows} rows");
        }
        assert!(least_eigenvector(&SMatrix::from_element(f64::NAN)).is_none());
        assert!(least_eigenvector(&SMatrix::zeros()).is_none());
    }
}
