//! Stands in for live topics where they were left out of the program.

use std::path::Path;

use anyhow::{Result, bail};
use visloc_core::Timestamp;
use visloc_slam::{FrameOutcome, Slam};

use super::SlamWatcher;

/// Cannot be made.
pub enum SlamLive {}

impl SlamLive {
    /// Says what is missing.
    ///
    /// # Errors
    /// Always.
    pub fn open(_: u16, _: Option<&Path>) -> Result<Self> {
        bail!("--publish-ros: this visloc was built without ROS 2; build with --features ros2")
    }
}

impl SlamWatcher for SlamLive {
    fn after_frame(&mut self, _: Timestamp, _: &FrameOutcome, _: &Slam) {
        match *self {}
    }

    fn takes_reset(&mut self) -> bool {
        match *self {}
    }
}
