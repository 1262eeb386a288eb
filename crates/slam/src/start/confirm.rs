//! When a start is believed.

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
/// Largest median deviation of depths that count as confirmed, in logarithms.
const CONFIRMED_DEVIATION: f64 = 0.06;
/// Least difference in the logarithm of the likelihood between two motions.
const CLEAR_LOG_ODDS: f64 = 15.0;
/// Least mean cost of an explained observation that is believed.
const LEAST_INLIER_COST: f64 = 0.05;

/// Whether the first of two motions explains the views so much better that it is no accident. The more corners, the smaller
/// the difference that tells; the errors of a corner in several views are alike, so that each corner counts once.
#[must_use]
pub fn is_clearly_better(best: &VerifiedStart, second: &VerifiedStart) -> bool {
    let num = best.points.len() as f64;
    num * (second.cost - best.cost) / best.inlier_cost.max(LEAST_INLIER_COST) > CLEAR_LOG_ODDS
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
        let both = earlier.depths.iter().zip(&depths);
        let mut ratios: Vec<f64> = both.filter_map(|(a, b)| Some(((*b)? / (*a)?).ln())).collect();
        if let Some(middle) = median(&mut ratios) {
            let mut deviations: Vec<f64> = ratios.iter().map(|ratio| (ratio - middle).abs()).collect();
            if median(&mut deviations).is_some_and(|deviation| deviation < CONFIRMED_DEVIATION) {
                return Ok(());
            }
        }
    }
    *pending = Some(PendingStart { parallax_rad, depths });
    Err(StartWait::Ambiguous)
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
