//! What a source borrows from the program that opens it.

use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use crate::Timestamp;

/// Clock, voice and stop sign of the program. Cheap to clone; the clones share the stop sign and what came of it.
#[derive(Clone)]
pub struct Host {
    clock: fn() -> Timestamp,
    notice: Arc<dyn Fn(&str) + Send + Sync>,
    is_stopped: Arc<AtomicBool>,
    was_interrupted: Arc<AtomicBool>,
    has_begun: Arc<AtomicBool>,
}

impl Host {
    /// With a clock for the stamps of live images, and a voice for what the user should know at once.
    pub fn new(clock: fn() -> Timestamp, notice: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self {
            clock,
            notice: Arc::new(notice),
            is_stopped: Arc::default(),
            was_interrupted: Arc::default(),
            has_begun: Arc::default(),
        }
    }

    /// A host without a voice whose time stands still. Recorded sources need no more.
    pub fn silent() -> Self {
        Self::new(Timestamp::default, |_| {})
    }

    /// The time now.
    pub fn now(&self) -> Timestamp {
        (self.clock)()
    }

    /// Says something to the user.
    pub fn notice(&self, text: &str) {
        (self.notice)(text);
    }

    /// Asks all sources to end.
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Whether sources were asked to end.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Notes that the stop sign ended something before its end; live sources have none.
    pub fn note_interruption(&self) {
        self.was_interrupted.store(true, Ordering::Relaxed);
    }

    /// Whether the stop sign ended something before its end.
    pub fn was_interrupted(&self) -> bool {
        self.was_interrupted.load(Ordering::Relaxed)
    }

    /// Notes that a source has delivered something.
    pub fn note_begin(&self) {
        self.has_begun.store(true, Ordering::Relaxed);
    }

    /// Whether a source has delivered something, so that there may be results.
    pub fn has_begun(&self) -> bool {
        self.has_begun.load(Ordering::Relaxed)
    }

    /// The stop sign itself, for whoever waits without a host.
    pub fn stop_sign(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.is_stopped)
    }
}

impl fmt::Debug for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Host").field("is_stopped", &self.is_stopped()).finish_non_exhaustive()
    }
}
