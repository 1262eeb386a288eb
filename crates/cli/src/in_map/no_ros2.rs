//! Stands in for live topics where they were left out of the program: says what is missing.

use anyhow::{Result, bail};
use visloc_io::bag::ResultFrames;
use visloc_vmap::VisualMap;

use crate::slam::MapWatcher;

pub fn open_map_live(_: u16, _: ResultFrames, _: (&str, Option<&VisualMap>)) -> Result<Box<dyn MapWatcher>> {
    bail!("--publish-ros: this visloc was built without ROS 2; build with --features ros2")
}
