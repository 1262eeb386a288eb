//! Stands in for live topics where they were left out of the program.

use anyhow::{Result, bail};

use super::{FrameView, LiveReport, Spectator};

/// Cannot be made.
pub enum LiveOutput {}

impl LiveOutput {
    /// Says what is missing.
    ///
    /// # Errors
    /// Always.
    pub fn open(_: u16, _: &str) -> Result<Self> {
        bail!("--publish-ros: this visloc was built without ROS 2; build with --features ros2")
    }

    /// Nothing is ever reported.
    pub fn report(&self) -> LiveReport {
        match *self {}
    }
}

impl Spectator for LiveOutput {
    fn after_frame(&mut self, _: &FrameView<'_>) {
        match *self {}
    }
}
