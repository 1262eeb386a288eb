//! Normal equations of small least-squares problems.

use nalgebra::{SMatrix, SVector};

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
