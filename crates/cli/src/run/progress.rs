//! A progress bar on a terminal; nothing in a pipe.

use std::fmt::Write;

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

use super::{FrameView, Spectator};

/// How far a run has come. Drawn to standard error, so that standard output stays clean.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar for a number of frames, if that is known.
    pub fn new(num_frames: Option<usize>) -> Self {
        let bar = num_frames.map_or_else(ProgressBar::new_spinner, |frames| ProgressBar::new(frames as u64));
        set_style(
            &bar,
            match num_frames {
                Some(_) => "{wide_bar} {pos}/{len} frames  {rate}  {left}  {msg}",
                None => "{spinner} {pos} frames  {rate}  {msg}",
            },
        );
        Self { bar }
    }

    /// Nothing, for runs of which there are several at the same time.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden() }
    }

    /// A line that stays until it is cleared.
    pub fn message(text: &'static str) -> Self {
        let bar = ProgressBar::new_spinner();
        bar.set_message(text);
        bar.tick();
        Self { bar }
    }

    /// A bar for the runs of an experiment.
    pub fn runs() -> Self {
        let bar = ProgressBar::new(0);
        set_style(&bar, "{wide_bar} {pos}/{len} runs  {left}");
        Self { bar }
    }

    /// So much is done.
    pub fn set(&self, num_done: usize, num_wanted: usize) {
        self.bar.set_length(num_wanted as u64);
        self.bar.set_position(num_done as u64);
    }

    /// One frame is done.
    pub fn advance(&self) {
        self.bar.inc(1);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Says how a bar looks; `{left}` is the time that is left, once something is done that tells it, `{rate}` how much is done in a second.
fn set_style(bar: &ProgressBar, template: &str) {
    let Ok(style) = ProgressStyle::with_template(template) else { return };
    let left = |state: &ProgressState, text: &mut dyn Write| {
        if state.pos() > 0 {
            let _ = write!(text, "{:#} left", HumanDuration(state.eta()));
        }
    };
    let rate = |state: &ProgressState, text: &mut dyn Write| {
        let _ = write!(text, "{:.0}/s", state.per_sec());
    };
    bar.set_style(style.with_key("left", left).with_key("rate", rate));
}

impl Spectator for Progress {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        if let Some(record) = view.runners.first().and_then(|runner| runner.records().latest()) {
            self.bar.set_message(format!("reliability {:.2}", record.reliability));
        }
        self.advance();
    }
}
