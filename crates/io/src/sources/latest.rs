//! The newest of what a live source delivers.

use std::{
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use visloc_core::SourceError;

/// Longest wait before it is looked again whether to stop.
const WAIT: Duration = Duration::from_millis(50);

/// A place for one value. The writer never waits; a value that nobody has taken when the next one comes is dropped and
/// counted.
pub(crate) struct Latest<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

struct State<T> {
    newest: Option<T>,
    num_dropped: usize,
    /// The writer is done; why, if not in peace.
    end: Option<Option<SourceError>>,
}

/// What a reader finds.
pub(crate) enum Taken<T> {
    /// A value that nobody has had.
    New(T),
    /// Nothing new for a moment.
    Nothing,
    /// No more values will come; why, if not in peace. Said once, then without a reason.
    End(Option<SourceError>),
}

impl<T> Latest<T> {
    pub(crate) fn new() -> Self {
        let state = State { newest: None, num_dropped: 0, end: None };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Puts a value in; an older one that is still there is dropped.
    pub(crate) fn put(&self, value: T) {
        let mut state = self.lock();
        state.num_dropped += usize::from(state.newest.replace(value).is_some());
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
        if state.newest.is_none() && state.end.is_none() {
            let waited = self.changed.wait_timeout(state, WAIT);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        match (state.newest.take(), &mut state.end) {
            (Some(value), _) => Taken::New(value),
            (None, Some(error)) => Taken::End(error.take()),
            (None, None) => Taken::Nothing,
        }
    }

    pub(crate) fn num_dropped(&self) -> usize {
        self.lock().num_dropped
    }

    /// A panic in the writer leaves nothing half done here.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_newest_is_kept() {
        let latest = Latest::new();
        assert!(matches!(latest.take(), Taken::Nothing));
        (1..=5).for_each(|i| latest.put(i));
        assert!(matches!(latest.take(), Taken::New(5)));
        assert_eq!(latest.num_dropped(), 4);
        latest.put(6);
        latest.end(None);
        assert!(matches!(latest.take(), Taken::New(6)));
        assert!(matches!(latest.take(), Taken::End(None)));
    }
}
