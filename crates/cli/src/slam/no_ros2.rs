//! Stands in for live topics where they were left out of the program.

use anyhow::{Result, bail};
use visloc_core::Timestamp;
use visloc_slam::{FrameOutcome, Slam, map::MapId};
use visloc_vmap::VisualMap;

use super::{Restart, SlamWatcher};
use crate::args::SlamArgs;

/// Cannot be made.
pub enum SlamLive {}

impl SlamLive {
    /// Says what is missing.
    pub fn open(_: u16, _: &SlamArgs, _: Option<&VisualMap>) -> Result<Self> {
        bail!("--publish-ros: this visloc was built without ROS 2; build with --features ros2")
    }

    /// Never called.
    pub fn finish(self) -> (Option<VisualMap>, Option<(MapId, f64)>) {
        match self {}
    }
}

impl SlamWatcher for SlamLive {
    fn after_frame(&mut self, _: Timestamp, _: &FrameOutcome, _: &Slam) {
        match *self {}
    }

    fn takes_restart(&mut self) -> Option<Restart> {
        match *self {}
    }
}
