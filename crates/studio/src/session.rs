//! The trait of everything that a page can watch.

use serde_json::Value;

use crate::{Command, StudioError, Update, recording::Input};

/// Something that goes on in steps and can be watched. Sessions read no clock of their own and start no threads.
pub trait Session: Send {
    /// Does what somebody at a page wants.
    ///
    /// # Errors
    /// If the command makes no sense for this session; nothing has changed then.
    fn handle(&mut self, command: &Command) -> Result<(), StudioError>;

    /// Time from one step to the next; `None` while nothing goes on by itself.
    fn step_secs(&self) -> Option<f64>;

    /// One step.
    ///
    /// # Errors
    /// If it cannot go on; the session stays as it is.
    fn step(&mut self) -> Result<(), StudioError>;

    /// What there is to see now. `more` is a table that is laid over the state: what the engine has to say to the people at the
    /// pages.
    ///
    /// # Errors
    /// If it cannot be encoded.
    fn update(&mut self, more: Option<&Value>) -> Result<Update, StudioError>;

    /// Whether the last step has brought anything to be shown: what comes from elsewhere may not have come yet.
    fn has_news(&self) -> bool {
        true
    }

    /// What the algorithms were given for the last frame, so that a recording can be recomputed; `None` if nobody knows.
    fn input(&self) -> Option<Input<'_>> {
        None
    }
}
