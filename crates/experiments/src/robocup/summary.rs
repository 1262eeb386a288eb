//! Many runs of one contender in few numbers.

use super::record::{Calibration, ContenderRecord, KidnapScore};
use crate::mean;

/// The runs of one contender in one set.
pub(super) struct Summary<'a> {
    pub records: Vec<&'a ContenderRecord>,
}

/// Mean, worst run and so on of an error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Spread {
    /// Mean over the runs.
    pub mean: Option<f64>,
    /// The run with the largest value.
    pub worst: Option<f64>,
}

impl Spread {
    pub(super) fn of(values: impl Iterator<Item = Option<f64>>) -> Self {
        let values: Vec<f64> = values.flatten().collect();
        Self { mean: mean(&values), worst: values.iter().copied().reduce(f64::max) }
    }
}

pub(super) fn share(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// The value that a share of all values, 0 to 1, does not exceed; what never happened counts as infinite. `None` if there
/// are no values or the answer is infinite.
pub(super) fn quantile(values: impl Iterator<Item = Option<f64>>, probability: f64) -> Option<f64> {
    let values = crate::sorted(values.map(|value| value.unwrap_or(f64::INFINITY)));
    crate::quantile(&values, probability).filter(|value| value.is_finite())
}

impl Summary<'_> {
    pub(super) fn position_m(&self) -> Spread {
        Spread::of(self.records.iter().map(|record| record.position_error_m.mean))
    }

    pub(super) fn heading_deg(&self) -> Spread {
        Spread::of(self.records.iter().map(|record| record.heading_error_deg.mean))
    }

    pub(super) fn kidnaps(&self) -> impl Iterator<Item = &KidnapScore> {
        self.records.iter().flat_map(|record| &record.kidnaps)
    }

    pub(super) fn num_kidnaps(&self) -> usize {
        self.kidnaps().count()
    }

    /// How many kidnaps fulfill something.
    pub(super) fn count(&self, holds: impl Fn(&KidnapScore) -> bool) -> usize {
        self.kidnaps().filter(|kidnap| holds(kidnap)).count()
    }

    pub(super) fn calibration(&self) -> Calibration {
        let mut sum = Calibration::default();
        for record in &self.records {
            sum.add(&record.calibration);
        }
        sum
    }

    /// Mean of the normalized error in each run that has one.
    pub(super) fn nees_of_runs(&self) -> Vec<f64> {
        self.records.iter().filter_map(|record| record.mean_nees()).collect()
    }

    /// For every second: mean of the normalized error over the runs that track the robot then, and their number.
    pub(super) fn nees_over_time(&self) -> Vec<(f64, u32)> {
        let longest = self.records.iter().map(|record| record.consistency.at_secs.len()).max().unwrap_or(0);
        let at = |second: usize| {
            let values: Vec<f64> = self
                .records
                .iter()
                .filter_map(|record| record.consistency.at_secs.get(second).copied().flatten())
                .map(f64::from)
                .collect();
            (mean(&values).unwrap_or(f64::NAN), u32::try_from(values.len()).unwrap_or(u32::MAX))
        };
        (0..longest).map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_never_happened_is_slower_than_everything() {
        let values = [Some(1.0), None, Some(3.0), Some(2.0)];
        assert_eq!(quantile(values.into_iter(), 0.5), Some(2.0));
        assert_eq!(quantile(values.into_iter(), 0.9), None);
        assert_eq!(quantile(std::iter::empty(), 0.5), None);
    }
}
