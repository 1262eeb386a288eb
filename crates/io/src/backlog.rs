//! Images of a live source that wait while those before them are worked on.

use std::{
    collections::VecDeque,
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use visloc_core::{SourceError, Timestamp};

/// Longest wait before it is looked again whether to stop.
const WAIT: Duration = Duration::from_millis(50);

/// A queue of values with the times at which they came. Once one has waited too long when the next comes, only the next
/// counts: who is too slow for a moment misses nothing, who is too slow for good is never far behind.
#[derive(Debug)]
pub(crate) struct Backlog<T> {
    waiting: VecDeque<(Timestamp, T)>,
    most_secs: f64,
    num_dropped: usize,
}

impl<T> Backlog<T> {
    /// Values wait for so long at most; with 0 s only the newest counts.
    pub(crate) fn new(most_secs: f64) -> Self {
        Self { waiting: VecDeque::new(), most_secs, num_dropped: 0 }
    }

    /// Puts a value in, by the time at which it came. Those that are there are dropped if one has waited too long.
    pub(crate) fn put(&mut self, at: Timestamp, value: T) {
        // A clock that was set back counts as too long.
        if self.waiting.front().is_some_and(|(oldest, _)| at.secs_since(*oldest).abs() >= self.most_secs) {
            self.num_dropped += self.waiting.len();
            self.waiting.clear();
        }
        self.waiting.push_back((at, value));
    }

    /// The one that has waited longest.
    pub(crate) fn take(&mut self) -> Option<(Timestamp, T)> {
        self.waiting.pop_front()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// How many nobody has taken in time.
    pub(crate) fn num_dropped(&self) -> usize {
        self.num_dropped
    }
}

/// A backlog between a thread that puts values in, and never waits, and one that takes them.
pub(crate) struct SharedBacklog<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

struct State<T> {
    backlog: Backlog<T>,
    /// The writer is done; why, if not in peace.
    end: Option<Option<SourceError>>,
}

/// What a reader finds.
pub(crate) enum Taken<T> {
    /// A value that nobody has had, and when it came.
    New(Timestamp, T),
    /// Nothing new for a moment.
    Nothing,
    /// No more values will come; why, if not in peace. Said once, then without a reason.
    End(Option<SourceError>),
}

impl<T> SharedBacklog<T> {
    pub(crate) fn new(most_secs: f64) -> Self {
        let state = State { backlog: Backlog::new(most_secs), end: None };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Puts a value in; see [`Backlog::put`].
    pub(crate) fn put(&self, at: Timestamp, value: T) {
        self.lock().backlog.put(at, value);
        self.changed.notify_one();
    }

    /// Says that no more values come.
    pub(crate) fn end(&self, error: Option<SourceError>) {
        self.lock().end = Some(error);
        self.changed.notify_one();
    }

    /// Waits a moment for a value.
    pub(crate) fn take(&self) -> Taken<T> {
        let mut state = self.lock();
        if state.backlog.is_empty() && state.end.is_none() {
            let waited = self.changed.wait_timeout(state, WAIT);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        match (state.backlog.take(), &mut state.end) {
            (Some((at, value)), _) => Taken::New(at, value),
            (None, Some(error)) => Taken::End(error.take()),
            (None, None) => Taken::Nothing,
        }
    }

    pub(crate) fn num_dropped(&self) -> usize {
        self.lock().backlog.num_dropped()
    }

    /// A panic in the writer leaves nothing half done here.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: f64) -> Timestamp {
        Timestamp::from_secs(secs)
    }

    #[test]
    fn without_patience_only_the_newest_is_kept() {
        let shared = SharedBacklog::new(0.0);
        assert!(matches!(shared.take(), Taken::Nothing));
        (1..=5).for_each(|i| shared.put(at(1.0), i));
        assert!(matches!(shared.take(), Taken::New(_, 5)));
        assert_eq!(shared.num_dropped(), 4);
        shared.put(at(2.0), 6);
        shared.end(None);
        assert!(matches!(shared.take(), Taken::New(_, 6)));
        assert!(matches!(shared.take(), Taken::End(None)));
    }

    #[test]
    fn who_is_slow_for_a_moment_misses_nothing_and_who_is_too_slow_is_never_far_behind() {
        let mut backlog = Backlog::new(0.5);
        // 0.4 s of ten images a second, then all of them are taken.
        (0..5).for_each(|i| backlog.put(at(0.1 * f64::from(i)), i));
        let taken: Vec<_> = std::iter::from_fn(|| backlog.take()).map(|(_, i)| i).collect();
        assert_eq!((taken, backlog.num_dropped()), (vec![0, 1, 2, 3, 4], 0));
        // A reader of five images a second.
        let (mut behind, mut num_taken) = (0.0_f64, 0);
        for i in 0..1000 {
            let now = at(1.0 + 0.1 * f64::from(i));
            backlog.put(now, i);
            if i % 2 == 0 {
                let (came, _) = backlog.take().unwrap();
                behind = behind.max(now.secs_since(came));
                num_taken += 1;
            }
        }
        assert!(behind < 0.5 && num_taken == 500, "{behind} s behind, {num_taken} taken");
        assert!(backlog.num_dropped() > 480);
        // The clock is set back.
        backlog.put(at(0.0), -1);
        assert_eq!(backlog.take(), Some((at(0.0), -1)));
    }
}
