//! The demo in a pipe: one line for each event.

use super::EventLog;
use crate::{
    run::{FrameView, Spectator},
    say,
};

/// Prints events as they happen.
pub struct PlainLog {
    events: EventLog,
}

impl PlainLog {
    /// A log that has printed nothing yet.
    pub fn new(num_runners: usize) -> Self {
        Self { events: EventLog::new(num_runners) }
    }
}

impl Spectator for PlainLog {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        for event in self.events.update(view) {
            say::line!("{:6.1} s  {}", event.secs, event.text);
        }
    }
}
