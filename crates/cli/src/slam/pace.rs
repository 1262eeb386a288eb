//! Frames at the time at which they were taken.

use std::{thread, time::Duration};

use visloc_core::Timestamp;

use crate::stopwatch::Stopwatch;

/// How long an image may wait while those before it are worked on, seconds. A new map and a loop take the processor of a
/// small computer for some tenths of a second; what the camera sees meanwhile should not be missing. Later poses are of
/// little use to a robot that drives.
pub const BACKLOG_SECS: f64 = 0.5;

/// A camera that takes its images at their stamps; those wait for [`BACKLOG_SECS`] at most, then only the newest counts.
#[derive(Debug)]
pub struct Pace {
    watch: Stopwatch,
    first: Option<Timestamp>,
    last: Option<Timestamp>,
    is_too_late: bool,
}

impl Pace {
    /// Time begins with the first image.
    pub fn start() -> Self {
        Self { watch: Stopwatch::start(), first: None, last: None, is_too_late: false }
    }

    /// Waits until an image is taken. `false` if it is lost: it or one before it has waited too long, and the next image has been taken
    /// already.
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
        let is_newest = ahead + period > 0.0;
        self.is_too_late = !is_newest && (self.is_too_late || -ahead > BACKLOG_SECS);
        !self.is_too_late
    }
}

/// Longest wait for an image: a gap in a recording need not be sat out.
const MOST_WAIT_SECS: f64 = 1.0;
