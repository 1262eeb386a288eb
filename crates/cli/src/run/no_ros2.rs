//! Stands in for live topics where they were left out of the program.

use anyhow::{Result, bail};
use visloc_core::FloorPicture;
use visloc_world::Map;

use super::{FrameView, LiveReport, Spectator};

/// The robot's place in a team.
pub struct TeamSettings<'a> {
    /// Name of the team.
    pub name: &'a str,
    /// Number of the robot.
    pub number: u8,
    /// The map.
    pub map: &'a Map,
}

/// Cannot be made.
pub enum LiveOutput {}

impl LiveOutput {
    /// Says what is missing.
    pub fn open(_: u16, _: &str, team: Option<&TeamSettings<'_>>, _: Option<&FloorPicture>) -> Result<Self> {
        let what = match team {
            Some(team) => format!("--team {} --number {} on {}", team.name, team.number, team.map.name()),
            None => "--publish-ros".to_owned(),
        };
        bail!("{what}: this visloc was built without ROS 2; build with --features ros2")
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
