//! When a start is believed.

use visloc_core::median;

use super::{StartWait, VerifiedStart};

/// A start that is not believed yet.
#[derive(Debug, Clone)]
pub struct PendingStart {
    parallax_rad: f64,
    /// Depth of each corner, by its number.
    depths: Vec<Option<f64>>,
}

/// More parallax by this factor must confirm the depths of a start.
const CONFIRMING_PARALLAX: f64 = 1.25;
/// Largest deviation of depths, in logarithms, up to which they are taken for the same: about what a landmark of the first map is said to be exact to.
pub const SAME_DEVIATION: f64 = 0.06;
/// Least difference in the logarithm of the likelihood between two motions.
const CLEAR_LOG_ODDS: f64 = 15.0;
/// What a corner that was followed wrongly is worth: one in fifty is, and then it is anywhere among some hundred places that can be told apart.
const WRONG_CORNER_LOG_ODDS: f64 = 8.5;
/// Least mean cost of an explained observation that is believed.
const LEAST_INLIER_COST: f64 = 0.05;

/// How badly a motion explains the views; `inlier_cost` is what an explained observation costs. The errors of a corner in several views
/// are alike, so that each corner counts once; and one that the motion does not explain at all may have been followed wrongly, so that a
/// single one does not decide.
#[must_use]
pub fn negative_log_likelihood(start: &VerifiedStart, inlier_cost: f64) -> f64 {
    let scale = inlier_cost.max(LEAST_INLIER_COST);
    start.corner_costs.iter().map(|cost| (cost / scale).min(WRONG_CORNER_LOG_ODDS)).sum()
}

/// Whether the first of two motions explains the views so much better that it is no accident.
#[must_use]
pub fn is_clearly_better(best: &VerifiedStart, second: &VerifiedStart) -> bool {
    let inlier_cost = best.inlier_cost.min(second.inlier_cost);
    negative_log_likelihood(second, inlier_cost) - negative_log_likelihood(best, inlier_cost) > CLEAR_LOG_ODDS
}

/// Compares the depths of a start with those of an earlier one of less parallax. A true scene keeps its shape as the camera goes
/// on; a wrong one does not.
///
/// # Errors
/// What is waited for.
pub fn confirm(
    pending: &mut Option<PendingStart>,
    depths: Vec<Option<f64>>,
    parallax_rad: f64,
) -> Result<(), StartWait> {
    if let Some(earlier) = pending.take() {
        if parallax_rad < CONFIRMING_PARALLAX * earlier.parallax_rad {
            *pending = Some(earlier);
            return Err(StartWait::LittleParallax(parallax_rad));
        }
        if are_alike(&earlier.depths, &depths) {
            return Ok(());
        }
    }
    *pending = Some(PendingStart { parallax_rad, depths });
    Err(StartWait::Ambiguous)
}

/// Whether depths of the same corners are the same up to a common factor, for most of them.
#[must_use]
pub fn are_alike(some: &[Option<f64>], others: &[Option<f64>]) -> bool {
    let both = some.iter().zip(others);
    let ratios = both.filter_map(|(a, b)| Some(((*b)? / (*a)?).ln()));
    let Some(middle) = median(ratios.clone()) else { return false };
    median(ratios.map(|ratio| (ratio - middle).abs())).is_some_and(|deviation| deviation < SAME_DEVIATION)
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::Rigid3;

    use super::*;

    fn start(corner_costs: Vec<f64>) -> VerifiedStart {
        let explained: Vec<f64> = corner_costs.iter().copied().filter(|cost| *cost < 3.0).collect();
        VerifiedStart {
            last_from_first: Rigid3::identity(),
            points: vec![None; corner_costs.len()],
            cost: corner_costs.iter().sum::<f64>() / corner_costs.len() as f64,
            inlier_cost: explained.iter().sum::<f64>() / explained.len() as f64,
            corner_costs,
        }
    }

    #[test]
    fn depths_are_alike_in_any_unit_but_not_if_bent() {
        let depths: Vec<Option<f64>> =
            (0..40).map(|i| (i % 9 > 0).then(|| 2.0 + 0.1 * f64::from(i))).collect();
        let times = |factor: fn(f64) -> f64| -> Vec<Option<f64>> {
            depths.iter().map(|depth| depth.map(|depth| depth * factor(depth))).collect()
        };
        assert!(are_alike(&depths, &times(|_| 3.0)));
        assert!(!are_alike(&depths, &times(|depth| depth)));
        assert!(!are_alike(&depths, &[None; 40]), "nothing is known");
    }

    #[test]
    fn a_corner_that_was_followed_wrongly_does_not_choose_the_motion() {
        // The true motion explains all but one corner, another one explains all of them, worse.
        let truth = start([vec![0.06; 99], vec![3.0]].concat());
        let other = start(vec![0.064; 100]);
        assert!(truth.cost > other.cost, "the mean cost would choose the other one");
        assert!(!is_clearly_better(&other, &truth) && !is_clearly_better(&truth, &other));
        // With more of a difference, or more corners that are not explained, it is told.
        assert!(is_clearly_better(&truth, &start(vec![0.08; 100])));
        assert!(is_clearly_better(&other, &start([vec![0.06; 90], vec![3.0; 10]].concat())));
    }
}
