//! Stands in for live topics where they were left out of the program: says what is missing.

use anyhow::{Result, bail};
use visloc_vmap::VisualMap;

use super::SlamWatcher;
use crate::args::SlamArgs;

pub fn open_slam_live(_: u16, _: &SlamArgs, _: Option<&VisualMap>) -> Result<Box<dyn SlamWatcher>> {
    bail!("--publish-ros: this visloc was built without ROS 2; build with --features ros2")
}
