//! `visloc localize` in a map that SLAM has made.

mod diagnosis;
mod execute;
mod floor;
mod frames;
#[cfg(feature = "ros2")]
mod live;
#[cfg(not(feature = "ros2"))]
#[path = "no_ros2.rs"]
mod live;
mod photo;
mod report;
mod results;
mod watchers;

pub use execute::execute;
pub use floor::floor_of;
pub use photo::locate;
pub use report::{draw, is_metric, unit};

use crate::{args::LocalizeArgs, slam::is_map_of_slam};

/// Whether the map of a command is one of SLAM.
pub fn is_wanted(args: &LocalizeArgs) -> bool {
    args.map.as_deref().is_some_and(is_map_of_slam)
}
