//! Numbers that describe many errors, as `evo` gives them.

use serde::{Deserialize, Serialize};

/// Statistics of errors, in the unit of the errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Root of the mean square.
    pub rmse: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// Middle value; the mean of the two in the middle of an even number.
    pub median: f64,
    /// Standard deviation of the population.
    pub std: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Sum of the squares.
    pub sse: f64,
}

impl Statistics {
    /// Of some errors; `None` if there are none.
    pub fn of(errors: &[f64]) -> Option<Self> {
        let mut sorted = errors.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let n = sorted.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let sse = errors.iter().map(|e| e * e).sum::<f64>();
        let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n;
        let middle = sorted.len() / 2;
        let median = match sorted.len() % 2 {
            1 => sorted[middle],
            _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
        };
        Some(Self { rmse: (sse / n).sqrt(), mean, median, std: variance.sqrt(), min, max, sse })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let s = Statistics::of(&[4.0, 1.0, 3.0, 2.0]).unwrap();
        assert_eq!((s.mean, s.median, s.min, s.max, s.sse), (2.5, 2.5, 1.0, 4.0, 30.0));
        assert_eq!((s.rmse, s.std), (7.5_f64.sqrt(), 1.25_f64.sqrt()));
        assert!(Statistics::of(&[]).is_none());
    }
}
