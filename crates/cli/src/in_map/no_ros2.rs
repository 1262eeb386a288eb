//! Stands in for live topics where they were left out of the program.

use anyhow::{Result, bail};
use visloc_io::bag::ResultFrames;
use visloc_vmap::{MapLocalizer, VisualMap};

use super::{frames::MapFrame, watchers::MapWish};

/// Cannot be made.
pub enum MapLive {}

impl MapLive {
    /// Says what is missing.
    pub fn open(_: u16, _: ResultFrames, _: (&str, Option<&VisualMap>)) -> Result<Self> {
        bail!("--publish-ros: this visloc was built without ROS 2; build with --features ros2")
    }

    /// Never called.
    pub fn look(&mut self, _: &MapLocalizer, _: &MapFrame, _: usize) {
        match *self {}
    }

    /// Never called.
    pub fn take_wish(&mut self) -> Option<MapWish> {
        match *self {}
    }

    /// Never called.
    pub fn num_unsent(&self) -> usize {
        match *self {}
    }
}
