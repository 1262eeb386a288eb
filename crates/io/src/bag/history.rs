//! The recent samples of one quantity, by time.

use std::collections::VecDeque;

use visloc_core::Timestamp;

/// Longest time over which values are interpolated or held, seconds.
pub(super) const MAX_AGE_SECS: f64 = 0.5;
/// What moves is taken to go on for so many intervals of its topic beyond the last sample: until the next one is overdue.
const MAX_INTERVALS: f64 = 1.5;
/// ... but no longer than this, seconds.
const MAX_EXTRAPOLATED_SECS: f64 = 1.0;
/// Share of a new interval in the usual one.
const INTERVAL_SHARE: f64 = 0.1;
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
    /// The usual time between two samples, seconds. Gaps hardly count.
    interval_secs: Option<f64>,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { samples: VecDeque::new(), num_backward: 0, interval_secs: None }
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
            self.interval_secs = None;
            pushed = Pushed::Restarted;
        }
        self.num_backward = 0;
        if self.newest_at() == Some(at) {
            self.samples.pop_back();
        }
        if let Some(newest) = self.newest_at() {
            let secs = at.secs_since(newest);
            let usual = self.interval_secs.unwrap_or(secs);
            self.interval_secs = Some(usual + INTERVAL_SHARE * (secs.min(2.0 * usual) - usual));
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

    /// The last two samples until a time, and how far beyond the first of them the time is, as a multiple of the way to the second: for
    /// what goes on moving until the next sample comes. `None` if that one is overdue by the topic's usual interval.
    pub(super) fn beyond(&self, at: Timestamp) -> Option<(T, T, f64)> {
        let num_until = self.samples.partition_point(|(sample_at, _)| *sample_at <= at);
        let (before_at, a) = self.samples.get(num_until.checked_sub(2)?)?;
        let (last_at, b) = self.samples.get(num_until - 1)?;
        let interval_secs = last_at.secs_since(*before_at);
        let since_secs = at.secs_since(*last_at);
        let usual_secs = self.interval_secs.unwrap_or(interval_secs);
        let most_secs = (MAX_INTERVALS * usual_secs.min(interval_secs)).min(MAX_EXTRAPOLATED_SECS);
        (since_secs <= most_secs).then_some((*a, *b, 1.0 + since_secs / interval_secs))
    }

    /// Whether there are not yet two samples until a time.
    pub(super) fn is_beginning(&self, at: Timestamp) -> bool {
        self.samples.get(1).is_none_or(|(second_at, _)| *second_at > at)
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

    /// Drops what later times do not need: all but the last two samples until then.
    pub(super) fn forget_before(&mut self, at: Timestamp) {
        while self.samples.get(2).is_some_and(|(third_at, _)| *third_at <= at) {
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
        assert_eq!(history.samples.len(), 3);
    }

    /// Topics of 1 to 50 Hz, the last sample at 0 s, after a gap that ended long before.
    #[test]
    fn what_moves_goes_on_until_the_next_sample_is_overdue() {
        for rate in [1.0, 10.0, 30.0, 50.0] {
            let interval = 1.0 / rate;
            let begin = -50.0 * interval;
            let samples: Vec<f64> =
                [begin - 5.0].into_iter().chain((0..=50).map(|i| begin + interval * f64::from(i))).collect();
            let history = history(&samples);
            let reach_secs = (1.45 * interval).min(0.99);
            let (a, b, fraction) = history.beyond(at(reach_secs)).unwrap();
            assert!((a + fraction * (b - a) - reach_secs).abs() < 1e-6, "{rate} Hz");
            assert_eq!(history.beyond(at(1.6 * interval)), None, "{rate} Hz");
        }
        assert!(history(&[1.0]).is_beginning(at(1.2)) && history(&[1.0, 1.1]).is_beginning(at(1.05)));
        assert!(!history(&[1.0, 1.1]).is_beginning(at(1.2)));
    }
}
