//! The demo on a terminal.

use std::{io::Write, thread, time::Duration};

use console::Term;
use visloc_world::Map;

use super::{EventLog, screen::Screen};
use crate::{
    run::{FrameView, Spectator},
    stopwatch::Stopwatch,
};

/// The demo does not play faster than this many times real time, so that people can follow.
const MAX_REAL_TIME_FACTOR: f64 = 2.0;
/// Pictures a second.
const MAX_REDRAWS_PER_S: f64 = 20.0;

/// Redraws field and numbers in place.
pub struct LiveView {
    term: Term,
    screen: Screen,
    events: EventLog,
    watch: Stopwatch,
    drawn_secs: f64,
    num_lines: usize,
}

/// Whether there is somebody to watch, on a terminal that shows colors.
pub fn is_live_terminal() -> bool {
    Term::stdout().features().is_attended() && console::colors_enabled()
}

impl LiveView {
    /// A view that fits into the terminal; `None` if it is too small, or the map not a field.
    pub fn new(map: &Map, num_runners: usize) -> Option<Self> {
        let term = Term::buffered_stdout();
        let (rows, columns) = term.size_checked()?;
        let screen = Screen::new(map, columns.into(), rows.into())?;
        Some(Self {
            term,
            screen,
            events: EventLog::new(num_runners),
            watch: Stopwatch::start(),
            drawn_secs: f64::NEG_INFINITY,
            num_lines: 0,
        })
    }

    fn redraw(&mut self, view: &FrameView<'_>, wall_secs: f64) {
        let factor = if wall_secs > 0.0 { view.secs / wall_secs } else { 0.0 };
        let lines = self.screen.draw(view, self.events.events(), factor);
        // In place: back to the first line, and each line cleared behind its end.
        let mut text = if self.num_lines > 0 { format!("\x1b[{}A", self.num_lines) } else { String::new() };
        for line in &lines {
            text += &format!("\r{line}\x1b[K\n");
        }
        self.num_lines = lines.len();
        // A terminal that is gone must not stop the run.
        let _ = self.term.write_all(text.as_bytes()).and_then(|()| self.term.flush());
    }
}

impl Spectator for LiveView {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        let has_news = !self.events.update(view).is_empty();
        let ahead_secs = view.secs / MAX_REAL_TIME_FACTOR - self.watch.secs();
        if ahead_secs > 0.0 {
            thread::sleep(Duration::from_secs_f64(ahead_secs));
        }
        let wall_secs = self.watch.secs();
        if has_news || wall_secs - self.drawn_secs >= 1.0 / MAX_REDRAWS_PER_S {
            self.drawn_secs = wall_secs;
            self.redraw(view, wall_secs);
        }
    }
}
