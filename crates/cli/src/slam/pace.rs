//! Frames at the time at which they were taken.

use std::{thread, time::Duration};

use visloc_core::Timestamp;

use crate::stopwatch::Stopwatch;

/// A camera that takes its images at their stamps and keeps the newest only.
#[derive(Debug)]
pub struct Pace {
    watch: Stopwatch,
    first: Option<Timestamp>,
    last: Option<Timestamp>,
}

impl Pace {
    /// Time begins with the first image.
    pub fn start() -> Self {
        Self { watch: Stopwatch::start(), first: None, last: None }
    }

    /// Waits until an image is taken. `false` if the next image has already been taken meanwhile: this one is lost.
    pub fn wait_for(&mut self, at: Timestamp) -> bool {
        let Some(first) = self.first else {
            (self.first, self.last, self.watch) = (Some(at), Some(at), Stopwatch::start());
            return true;
        };
        let period = self.last.replace(at).map_or(0.0, |last| at.secs_since(last));
        let ahead = at.secs_since(first) - self.watch.secs();
        if ahead > 0.0 {
            thread::sleep(Duration::from_secs_f64(ahead.min(MOST_WAIT_SECS)));
        }
        ahead + period > 0.0
    }
}

/// Longest wait for an image: a gap in a recording need not be sat out.
const MOST_WAIT_SECS: f64 = 1.0;
