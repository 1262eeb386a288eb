//! Normal equations of small least-squares problems.

use nalgebra::{SMatrix, SVector, Vector2};

/// Adds a weighted residual to normal equations.
#[inline]
pub fn add_residual<const N: usize>(
    (hessian, gradient): (&mut SMatrix<f64, N, N>, &mut SVector<f64, N>),
    error: &Vector2<f64>,
    jacobian: &SMatrix<f64, 2, N>,
    weight: f64,
) {
    *hessian += weighted_product(jacobian, jacobian, weight);
    *gradient -= weighted_product(jacobian, error, weight);
}

/// `left' * right * weight`, for which nalgebra calls its loop over matrices of any size.
#[inline]
fn weighted_product<const M: usize, const N: usize>(
    left: &SMatrix<f64, 2, M>,
    right: &SMatrix<f64, 2, N>,
    weight: f64,
) -> SMatrix<f64, M, N> {
    let [first, second]: [SVector<f64, M>; 2] = [0, 1].map(|row| left.row(row).transpose());
    let mut product = SMatrix::zeros();
    for column in 0..N {
        let (x, y) = (right[(0, column)], right[(1, column)]);
        for row in 0..M {
            product[(row, column)] = (first[row] * x + second[row] * y) * weight;
        }
    }
    product
}

/// Solves a 7 x 7 system with a touch of damping, so that directions nothing is known of stay where they are. `None` if the
/// matrix is not positive definite.
pub fn solve_damped(
    mut hessian: SMatrix<f64, 7, 7>,
    gradient: &SVector<f64, 7>,
    damping: f64,
) -> Option<SVector<f64, 7>> {
    for i in 0..7 {
        hessian[(i, i)] += damping * hessian[(i, i)] + 1e-12;
    }
    let step = hessian.cholesky()?.solve(gradient);
    step.iter().all(|v| v.is_finite()).then_some(step)
}
