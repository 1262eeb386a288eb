//! The floor of a map of SLAM.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use visloc_core::OccupancyGrid;
use visloc_vmap::{ScaleSource, VisualMap};

/// The floor of the largest map, if that has meaning; the path is for errors.
pub fn floor_of(path: &Path, map: &VisualMap) -> Result<OccupancyGrid> {
    let is_known = |id| map.is_level(id) && map.scale(id).source != ScaleSource::Unknown;
    let Some(id) = map.largest().filter(|id| is_known(*id)) else {
        bail!(
            "expected a map in meters with z up, found {}; visloc map align --to gives it both, a robot's odometry as well",
            path.display()
        );
    };
    map.occupancy_grid(id).ok_or_else(|| anyhow!("nothing in {} stands in a robot's way", path.display()))
}
