//! Stands in for live topics where they were left out of the program: says what is missing.

use anyhow::{Result, bail};
use visloc_core::OccupancyGrid;
use visloc_io::sources::SourceOptions;
use visloc_world::Map;

use super::Spectator;
use crate::args::LocalizeArgs;

pub fn open_live(
    args: &LocalizeArgs,
    _: &SourceOptions,
    map: &Map,
    _: Option<&OccupancyGrid>,
) -> Result<Box<dyn Spectator>> {
    let what = match args.team.as_deref().zip(args.number) {
        Some((name, number)) => format!("--team {name} --number {number} on {}", map.name()),
        None => "--publish-ros".to_owned(),
    };
    bail!("{what}: this visloc was built without ROS 2; build with --features ros2")
}
