//! A floor picture of a map, as the map server of ROS reads it.

use nalgebra::{Point2, Point3};
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

/// Gray values of the map server: occupied, unknown, free.
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

/// A floor picture.
#[derive(Debug, Clone, PartialEq)]
pub struct FloorPicture {
    /// Width and height, cells.
    pub size: (usize, usize),
    /// Rows from top (largest y) to bottom: 0 occupied, 254 free, 205 unknown.
    pub cells: Vec<u8>,
    /// Length of a cell, meters.
    pub cell_m: f64,
    /// Lower left corner, meters.
    pub origin_m: (f64, f64),
}

impl FloorPicture {
    /// The picture as PGM.
    #[must_use]
    pub fn to_pgm(&self) -> Vec<u8> {
        let mut bytes = format!("P5\n{} {}\n255\n", self.size.0, self.size.1).into_bytes();
        bytes.extend(&self.cells);
        bytes
    }

    /// What the map server reads, for a picture of a name.
    #[must_use]
    pub fn to_yaml(&self, picture: &str) -> String {
        let (x, y) = self.origin_m;
        format!(
            "image: {picture}\nresolution: {}\norigin: [{x:.3}, {y:.3}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
            self.cell_m
        )
    }

    fn cell(&self, x: f64, y: f64) -> Option<usize> {
        let column = ((x - self.origin_m.0) / self.cell_m).floor();
        let row = ((y - self.origin_m.1) / self.cell_m).floor();
        let is_inside =
            column >= 0.0 && row >= 0.0 && column < self.size.0 as f64 && row < self.size.1 as f64;
        is_inside.then(|| (self.size.1 - 1 - row as usize) * self.size.0 + column as usize)
    }

    fn set(&mut self, x: f64, y: f64, value: u8) {
        if let Some(cell) = self.cell(x, y) {
            self.cells[cell] = value;
        }
    }

    /// Cells between two places are free.
    fn clear(&mut self, from: &Point2<f64>, to: &Point2<f64>) {
        let steps = (2.0 * (to - from).norm() / self.cell_m).ceil().min(2.0 * MOST_CELLS as f64) as usize;
        for i in 0..steps {
            let at = from + (to - from) * (i as f64 / steps as f64);
            self.set(at.x, at.y, FREE);
        }
    }
}

impl VisualMap {
    /// The floor of one of the maps, which must have z up and be in meters: landmarks at heights at which a robot runs into things are occupied, what lies
    /// between them and the cameras that saw them is free. `None` without landmarks, or if it is longer than 400 m.
    #[must_use]
    pub fn floor_picture(&self, map: MapId) -> Option<FloorPicture> {
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
        let mut picture = FloorPicture {
            size,
            cells: vec![UNKNOWN; size.0 * size.1],
            cell_m: CELL_M,
            origin_m: (x.0 - margin, y.0 - margin),
        };
        for landmark in &obstacles {
            let to = landmark.point_in_world.xy();
            for observation in &landmark.observations {
                let center = of_map.keyframe(observation.keyframe).center_in_world();
                picture.clear(&center.xy(), &to);
            }
        }
        for landmark in &obstacles {
            picture.set(landmark.point_in_world.x, landmark.point_in_world.y, OCCUPIED);
        }
        Some(picture)
    }
}
