//! Shows a run to a recording and to pages.

use std::{thread, time::Duration};

use anyhow::Result;
use visloc_studio::view::{ContenderView, RunViewer};
use visloc_world::Map;

use super::{FrameView, Runner, Spectator};
use crate::{broadcast::Broadcast, stopwatch::Stopwatch};

/// Longest wait for a frame: a gap in a recording need not be sat out.
const MOST_WAIT_SECS: f64 = 1.0;

/// A spectator that shows what it sees to others.
pub struct Show {
    broadcast: Broadcast,
    viewer: RunViewer,
    watch: Stopwatch,
}

impl Show {
    /// Shows a run on a map.
    pub fn new(broadcast: Broadcast, map: &Map, title: &str) -> Self {
        Self { broadcast, viewer: RunViewer::new(map, title), watch: Stopwatch::start() }
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// If anything went wrong on the way.
    pub fn finish(self) -> Result<()> {
        self.broadcast.finish()
    }
}

impl Spectator for Show {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        if self.broadcast.is_live() {
            let ahead_secs = view.secs - self.watch.secs();
            if ahead_secs > 0.0 {
                thread::sleep(Duration::from_secs_f64(ahead_secs.min(MOST_WAIT_SECS)));
            }
        }
        if !self.broadcast.is_wanted() {
            return;
        }
        let contenders: Vec<ContenderView<'_>> = view.runners.iter().map(contender).collect();
        self.broadcast.send(self.viewer.update(view.frame, view.truth, &contenders));
    }
}

fn contender(runner: &Runner) -> ContenderView<'_> {
    let last = runner.records().last();
    ContenderView {
        name: runner.name(),
        pipeline: runner.pipeline(),
        analysis_ms: last.map_or(0.0, |record| record.analysis_ms),
        localizer_ms: last.map_or(0.0, |record| record.localizer_ms),
    }
}
