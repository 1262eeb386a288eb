//! The trait of everything that a page can watch.

use crate::{Command, StudioError, Update};

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

    /// What there is to see now. `notice` is for the people at the pages.
    ///
    /// # Errors
    /// If it cannot be encoded.
    fn update(&mut self, notice: Option<&str>) -> Result<Update, StudioError>;
}
