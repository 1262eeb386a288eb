//! The recent samples of one quantity, by time.

use std::collections::VecDeque;

use visloc_base::Timestamp;

/// Longest time over which values are interpolated or held, seconds.
pub(super) const MAX_AGE_SECS: f64 = 0.5;
/// Most samples that are kept, for recordings whose pictures stop.
const MAX_SAMPLES: usize = 4096;
/// After so many samples in a row that lie before the newest one, the clock is believed to have been set back.
const MAX_BACKWARD: u32 = 5;

/// What became of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pushed {
    /// It was taken.
    Accepted,
    /// It was taken after the clock had been set back; what was known before is forgotten.
    Restarted,
    /// It lies before the newest sample and was not taken.
    Backward {
        /// Stamp of the newest sample.
        newest: Timestamp,
    },
}

/// What is known about the value at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Lookup<T> {
    /// Between two samples: `fraction` in [0, 1) of the way from the first to the second.
    Between(T, T, f64),
    /// There is a sample on one side only; its value.
    Held(T),
}

/// Samples in order of time, bounded in number.
#[derive(Debug, Clone)]
pub(super) struct History<T> {
    samples: VecDeque<(Timestamp, T)>,
    num_backward: u32,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { samples: VecDeque::new(), num_backward: 0 }
    }
}

impl<T: Copy> History<T> {
    /// Adds a sample. One with the stamp of the newest replaces it.
    pub(super) fn push(&mut self, at: Timestamp, value: T) -> Pushed {
        let mut pushed = Pushed::Accepted;
        if let Some(newest) = self.newest_at().filter(|newest| at < *newest) {
            self.num_backward += 1;
            if self.num_backward < MAX_BACKWARD {
                return Pushed::Backward { newest };
            }
            self.samples.clear();
            pushed = Pushed::Restarted;
        }
        self.num_backward = 0;
        if self.newest_at() == Some(at) {
            self.samples.pop_back();
        }
        if self.samples.len() == MAX_SAMPLES {
            self.samples.pop_front();
        }
        self.samples.push_back((at, value));
        pushed
    }

    pub(super) fn newest_at(&self) -> Option<Timestamp> {
        self.samples.back().map(|(at, _)| *at)
    }

    pub(super) fn newest(&self) -> Option<(Timestamp, T)> {
        self.samples.back().copied()
    }

    /// Value at a time, from samples at most [`MAX_AGE_SECS`] apart.
    pub(super) fn lookup(&self, at: Timestamp) -> Option<Lookup<T>> {
        let num_until = self.samples.partition_point(|(sample_at, _)| *sample_at <= at);
        let before = num_until.checked_sub(1).and_then(|i| self.samples.get(i));
        let after = self.samples.get(num_until);
        match (before, after) {
            (Some((before_at, value)), _) if *before_at == at => Some(Lookup::Between(*value, *value, 0.0)),
            (Some((before_at, a)), Some((after_at, b)))
                if after_at.secs_since(*before_at) <= MAX_AGE_SECS =>
            {
                let fraction = at.secs_since(*before_at) / after_at.secs_since(*before_at);
                Some(Lookup::Between(*a, *b, fraction))
            }
            _ => self.nearest(at, MAX_AGE_SECS).map(Lookup::Held),
        }
    }

    /// Value of the sample nearest in time, within a tolerance.
    pub(super) fn nearest(&self, at: Timestamp, tolerance_secs: f64) -> Option<T> {
        let distance = |sample: &&(Timestamp, T)| sample.0.secs_since(at).abs();
        let num_until = self.samples.partition_point(|(sample_at, _)| *sample_at <= at);
        [num_until.checked_sub(1), Some(num_until)]
            .into_iter()
            .flatten()
            .filter_map(|i| self.samples.get(i))
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .filter(|sample| distance(sample) <= tolerance_secs)
            .map(|(_, value)| *value)
    }

    /// Value of the last sample at or before a time, however old.
    pub(super) fn last_until(&self, at: Timestamp) -> Option<T> {
        let num_until = self.samples.partition_point(|(sample_at, _)| *sample_at <= at);
        num_until.checked_sub(1).and_then(|i| self.samples.get(i)).map(|(_, value)| *value)
    }

    /// Drops what later times do not need.
    pub(super) fn forget_before(&mut self, at: Timestamp) {
        while self.samples.get(1).is_some_and(|(second_at, _)| *second_at <= at) {
            self.samples.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: f64) -> Timestamp {
        Timestamp::from_secs(secs)
    }

    fn history(samples: &[f64]) -> History<f64> {
        let mut history = History::default();
        for secs in samples {
            assert_eq!(history.push(at(*secs), *secs), Pushed::Accepted);
        }
        history
    }

    #[test]
    fn values_between_at_and_beside_samples() {
        let history = history(&[1.0, 1.2, 3.0]);
        assert_eq!(history.lookup(at(1.2)), Some(Lookup::Between(1.2, 1.2, 0.0)));
        let Some(Lookup::Between(a, b, fraction)) = history.lookup(at(1.05)) else { panic!() };
        assert!(a == 1.0 && b == 1.2 && (fraction - 0.25).abs() < 1e-9);
        assert_eq!(history.lookup(at(1.4)), Some(Lookup::Held(1.2)));
        assert_eq!(history.lookup(at(2.1)), None);
        assert_eq!(history.lookup(at(0.9)), Some(Lookup::Held(1.0)));
        assert_eq!(history.last_until(at(2.1)), Some(1.2));
        assert_eq!(history.last_until(at(0.9)), None);
    }

    #[test]
    fn single_backward_samples_are_refused_and_many_restart() {
        let mut history = history(&[1.0, 2.0]);
        for i in 1..MAX_BACKWARD {
            let pushed = history.push(at(0.1 * f64::from(i)), 0.0);
            assert_eq!(pushed, Pushed::Backward { newest: at(2.0) });
        }
        assert_eq!(history.push(at(0.6), 7.0), Pushed::Restarted);
        assert_eq!(history.newest_at(), Some(at(0.6)));
    }

    #[test]
    fn number_of_samples_is_bounded() {
        let mut history = History::default();
        for i in 0..10_000 {
            history.push(Timestamp::from_nanos(i), i);
        }
        assert_eq!(history.samples.len(), MAX_SAMPLES);
        history.forget_before(Timestamp::from_nanos(9_998));
        assert_eq!(history.samples.len(), 2);
    }
}
