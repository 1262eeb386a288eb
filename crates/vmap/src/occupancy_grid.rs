//! A map of SLAM as an occupancy grid.

use nalgebra::Point3;
use visloc_core::{Occupancy, OccupancyGrid};
use visloc_slam::map::MapId;

use crate::VisualMap;

/// Length of a cell, meters.
const CELL_M: f64 = 0.05;
/// Heights between which something stands in a robot's way, meters.
const HEIGHTS_M: (f64, f64) = (0.1, 2.0);
/// Keyframes that must see a landmark that stands in the way.
const LEAST_SEEN: usize = 3;
/// Floor around all that is known, cells.
const MARGIN: usize = 10;
/// Most cells on a side: 400 m.
const MOST_CELLS: usize = 8000;
/// Share of the landmarks on each side of an axis that may be mistakes.
const BESIDE: f64 = 0.01;

impl VisualMap {
    /// The floor of one of the maps, which must have z up and be in meters: landmarks at heights at which a robot runs into things are occupied, what lies
    /// between them and the cameras that saw them is free. `None` without landmarks, or if it is longer than 400 m.
    pub fn occupancy_grid(&self, map: MapId) -> Option<OccupancyGrid> {
        let of_map = self.map.with_active(map);
        let stands = |point: &Point3<f64>| point.z > HEIGHTS_M.0 && point.z < HEIGHTS_M.1;
        let obstacles: Vec<_> = of_map
            .landmarks()
            .map(|(_, landmark)| landmark)
            .filter(|l| l.is_converged() && l.observations.len() >= LEAST_SEEN && stands(&l.point_in_world))
            .collect();
        let range = |axis: usize| {
            let mut values: Vec<f64> = obstacles.iter().map(|l| l.point_in_world[axis]).collect();
            values.sort_by(f64::total_cmp);
            let beside = (values.len() as f64 * BESIDE) as usize;
            let cameras = of_map.keyframes().map(|(_, keyframe)| keyframe.center_in_world()[axis]);
            let least = *values.get(beside)?;
            let most = *values.iter().rev().nth(beside)?;
            Some(cameras.fold((least, most), |(least, most), value| (least.min(value), most.max(value))))
        };
        let (x, y) = (range(0)?, range(1)?);
        let num = |(least, most): (f64, f64)| ((most - least) / CELL_M).ceil() as usize + 2 * MARGIN;
        let size = (num(x), num(y));
        if size.0 > MOST_CELLS || size.1 > MOST_CELLS {
            return None;
        }
        let margin = MARGIN as f64 * CELL_M;
        let mut grid = OccupancyGrid::unknown(CELL_M, (x.0 - margin, y.0 - margin), size);
        for landmark in &obstacles {
            let to = landmark.point_in_world.xy();
            for keyframe in landmark.observations.keyframes() {
                let center = of_map.keyframe(keyframe).center_in_world();
                grid.draw(&center.xy(), &to, Occupancy::Free);
            }
        }
        for landmark in &obstacles {
            grid.set(landmark.point_in_world.x, landmark.point_in_world.y, Occupancy::Occupied);
        }
        Some(grid)
    }
}
