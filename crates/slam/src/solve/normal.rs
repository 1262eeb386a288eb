//! Normal equations of small least-squares problems.

use nalgebra::{Matrix6, Vector6};

/// Solves a 6 x 6 system with a touch of damping, so that directions nothing is known of stay where they are. `None` if the
/// matrix is not positive definite.
pub fn solve_damped(mut hessian: Matrix6<f64>, gradient: &Vector6<f64>, damping: f64) -> Option<Vector6<f64>> {
    for i in 0..6 {
        hessian[(i, i)] += damping * hessian[(i, i)] + 1e-12;
    }
    let step = hessian.cholesky()?.solve(gradient);
    step.iter().all(|v| v.is_finite()).then_some(step)
}
