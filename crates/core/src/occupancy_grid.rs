//! An occupancy grid, as the map server of ROS reads it and others draw it.

use nalgebra::Point2;

/// Gray values of the map server.
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

/// What is known of a cell of the floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occupancy {
    /// Something stands there.
    Occupied,
    /// Nobody knows.
    Unknown,
    /// A robot can be there.
    Free,
}

/// The floor from above, x to the right and y up.
#[derive(Debug, Clone, PartialEq)]
pub struct OccupancyGrid {
    /// Width and height, cells.
    pub size: (usize, usize),
    /// Rows from top (largest y) to bottom: 0 occupied, 254 free, 205 unknown.
    pub cells: Vec<u8>,
    /// Length of a cell, meters.
    pub cell_m: f64,
    /// Lower left corner, meters.
    pub origin_m: (f64, f64),
}

impl OccupancyGrid {
    /// A floor of which nothing is known: the lower left corner in meters, and how many cells.
    pub fn unknown(cell_m: f64, origin_m: (f64, f64), size: (usize, usize)) -> Self {
        Self { size, cells: vec![UNKNOWN; size.0 * size.1], cell_m, origin_m }
    }

    /// The cells as PGM.
    pub fn to_pgm(&self) -> Vec<u8> {
        let mut bytes = format!("P5\n{} {}\n255\n", self.size.0, self.size.1).into_bytes();
        bytes.extend(&self.cells);
        bytes
    }

    /// What the map server reads, for a PGM of a name.
    pub fn to_yaml(&self, picture: &str) -> String {
        let (x, y) = self.origin_m;
        format!(
            "image: {picture}\nresolution: {}\norigin: [{x:.3}, {y:.3}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
            self.cell_m
        )
    }

    /// Rows from bottom to top, each from left to right.
    pub fn rows_up(&self) -> impl Iterator<Item = Occupancy> {
        let cell = |gray: &u8| match *gray {
            OCCUPIED => Occupancy::Occupied,
            FREE => Occupancy::Free,
            _ => Occupancy::Unknown,
        };
        self.cells.chunks(self.size.0.max(1)).rev().flatten().map(cell)
    }

    /// Says what is at a place, meters; beside the grid nothing happens.
    pub fn set(&mut self, x_m: f64, y_m: f64, cell: Occupancy) {
        if let Some(index) = self.index_of(x_m, y_m) {
            self.cells[index] = match cell {
                Occupancy::Occupied => OCCUPIED,
                Occupancy::Unknown => UNKNOWN,
                Occupancy::Free => FREE,
            };
        }
    }

    /// The same for all cells between two places.
    pub fn draw(&mut self, from: &Point2<f64>, to: &Point2<f64>, cell: Occupancy) {
        let most = 2.0 * (self.size.0 + self.size.1) as f64;
        let num_steps = (2.0 * (to - from).norm() / self.cell_m).ceil().min(most) as usize;
        for i in 0..num_steps {
            let at = from + (to - from) * (i as f64 / num_steps as f64);
            self.set(at.x, at.y, cell);
        }
    }

    /// Middle of a cell, meters: columns from the left, rows from the bottom.
    pub fn middle(&self, column: usize, row: usize) -> Point2<f64> {
        let along = |origin_m: f64, index: usize| origin_m + (index as f64 + 0.5) * self.cell_m;
        Point2::new(along(self.origin_m.0, column), along(self.origin_m.1, row))
    }

    fn index_of(&self, x_m: f64, y_m: f64) -> Option<usize> {
        let column = ((x_m - self.origin_m.0) / self.cell_m).floor();
        let row = ((y_m - self.origin_m.1) / self.cell_m).floor();
        let is_inside =
            column >= 0.0 && row >= 0.0 && column < self.size.0 as f64 && row < self.size.1 as f64;
        is_inside.then(|| (self.size.1 - 1 - row as usize) * self.size.0 + column as usize)
    }
}
