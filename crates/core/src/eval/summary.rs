//! Numbers that describe many numbers.

use serde::{Deserialize, Serialize};

use crate::{mean, quantile};

/// Statistics of errors, in the unit of the errors; all `None` if there are none.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// Arithmetic mean.
    pub mean: Option<f64>,
    /// Middle value; see [`ErrorSummary::of`].
    pub median: Option<f64>,
    /// Root of the mean of squares.
    pub rmse: Option<f64>,
    /// Value below which 95 % lie.
    pub p95: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
}

impl ErrorSummary {
    /// Statistics of the finite ones among `errors`. Median and percentiles are exact: the errors are sorted, and the
    /// value at rank `p * (n - 1)` (from 0) is taken, linear between the two nearest ranks.
    pub fn of(errors: &[f64]) -> Self {
        let sorted = sorted_finite(errors);
        let squares: Vec<f64> = sorted.iter().map(|error| error * error).collect();
        Self {
            mean: mean(&sorted),
            median: quantile(&sorted, 0.5),
            rmse: mean(&squares).map(f64::sqrt),
            p95: quantile(&sorted, 0.95),
            max: sorted.last().copied(),
        }
    }
}

/// Statistics of durations, milliseconds; all `None` if there are none.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct TimingSummary {
    /// Arithmetic mean.
    pub mean: Option<f64>,
    /// Middle value.
    pub median: Option<f64>,
    /// Value below which 99 % lie.
    pub p99: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
}

impl TimingSummary {
    /// Statistics of the finite ones among `durations_ms`, with percentiles as in [`ErrorSummary::of`].
    pub fn of_ms(durations_ms: &[f64]) -> Self {
        let sorted = sorted_finite(durations_ms);
        Self {
            mean: mean(&sorted),
            median: quantile(&sorted, 0.5),
            p99: quantile(&sorted, 0.99),
            max: sorted.last().copied(),
        }
    }
}

fn sorted_finite(values: &[f64]) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn statistics_by_hand() {
        let summary = ErrorSummary::of(&[4.0, 1.0, 2.0, 3.0, f64::NAN]);
        assert_eq!(summary.mean, Some(2.5));
        assert_eq!(summary.median, Some(2.5));
        assert_eq!(summary.rmse, Some(7.5_f64.sqrt()));
        // rank 0.95 * 3 = 2.85
        assert!((summary.p95.unwrap() - 3.85).abs() < 1e-12);
        assert_eq!(summary.max, Some(4.0));
        assert_eq!(ErrorSummary::of(&[]), ErrorSummary::default());
        let timing = TimingSummary::of_ms(&[3.0]);
        let three = Some(3.0);
        assert_eq!(timing, TimingSummary { mean: three, median: three, p99: three, max: three });
    }

    proptest! {
        #[test]
        fn order_of_the_values_does_not_matter(mut values in prop::collection::vec(0.0..9.0f64, 1..50)) {
            let summary = ErrorSummary::of(&values);
            values.reverse();
            prop_assert_eq!(ErrorSummary::of(&values), summary);
            prop_assert!(summary.median <= summary.p95 && summary.p95 <= summary.max && summary.mean <= summary.max);
        }
    }
}
