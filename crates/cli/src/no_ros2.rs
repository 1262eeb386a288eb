//! Stands in for live topics where they were left out of the program: says what is missing.

use anyhow::{Result, bail};
use visloc_core::FloorPicture;
use visloc_io::{bag::ResultFrames, sources::SourceOptions};
use visloc_vmap::VisualMap;
use visloc_world::Map;

use crate::{
    args::{LocalizeArgs, SlamArgs},
    in_map::MapWatcher,
    run::Spectator,
    slam::SlamWatcher,
};

fn missing<T>(what: &str) -> Result<T> {
    bail!("{what}: this visloc was built without ROS 2; build with --features ros2")
}

pub fn open_live(
    args: &LocalizeArgs,
    _: &SourceOptions,
    map: &Map,
    _: Option<&FloorPicture>,
) -> Result<Box<dyn Spectator>> {
    match args.team.as_deref().zip(args.number) {
        Some((name, number)) => missing(&format!("--team {name} --number {number} on {}", map.name())),
        None => missing("--publish-ros"),
    }
}

pub fn open_slam_live(_: u16, _: &SlamArgs, _: Option<&VisualMap>) -> Result<Box<dyn SlamWatcher>> {
    missing("--publish-ros")
}

pub fn open_map_live(_: u16, _: ResultFrames, _: (&str, Option<&VisualMap>)) -> Result<Box<dyn MapWatcher>> {
    missing("--publish-ros")
}
