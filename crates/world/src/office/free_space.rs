//! Where a robot can be: the floor, a little off the walls.

use nalgebra::Point2;

use super::{OfficePlan, Wall, geometry::is_inside};

/// Side of a cell, meters.
const CELL_M: f64 = 0.1;
/// A robot's middle does not come nearer to a wall, meters.
const CLEARANCE_M: f64 = 0.1;

/// Where a robot can be, in square cells of 0.1 m.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeSpace {
    min: Point2<f64>,
    columns: usize,
    rows: usize,
    is_free: Vec<bool>,
    /// Indices of the free cells.
    free: Vec<u32>,
}

#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
impl FreeSpace {
    pub(super) fn new(plan: &OfficePlan, walls: &[Wall]) -> Self {
        let ends = || walls.iter().flat_map(|wall| [wall.start, wall.end]);
        let min = ends().fold(Point2::new(f64::MAX, f64::MAX), |m, p| m.inf(&p));
        let max = ends().fold(Point2::new(f64::MIN, f64::MIN), |m, p| m.sup(&p));
        let count = |size_m: f64| (size_m / CELL_M).ceil().max(1.0) as usize;
        let (columns, rows) = (count(max.x - min.x), count(max.y - min.y));
        let mut space = Self { min, columns, rows, is_free: vec![false; columns * rows], free: Vec::new() };
        space.fill(plan);
        for wall in walls {
            space.clear_along(wall);
        }
        space.free = (0..space.is_free.len()).filter(|i| space.is_free[*i]).map(|i| i as u32).collect();
        space
    }

    /// Floor is what lies inside an odd number of outlines; without outlines, everything between the walls.
    fn fill(&mut self, plan: &OfficePlan) {
        for row in 0..self.rows {
            for column in 0..self.columns {
                let middle = self.middle(column, row);
                let inside = plan.corridors.iter().filter(|c| is_inside(&c.outline, &middle)).count();
                self.is_free[row * self.columns + column] = plan.corridors.is_empty() || inside % 2 == 1;
            }
        }
    }

    /// Nothing is free within the clearance of a wall.
    fn clear_along(&mut self, wall: &Wall) {
        let low = wall.start.inf(&wall.end) - self.min;
        let high = wall.start.sup(&wall.end) - self.min;
        let cell = |m: f64, count: usize| ((m / CELL_M).floor().max(0.0) as usize).min(count - 1);
        for row in cell(low.y - CLEARANCE_M, self.rows)..=cell(high.y + CLEARANCE_M, self.rows) {
            for column in cell(low.x - CLEARANCE_M, self.columns)..=cell(high.x + CLEARANCE_M, self.columns) {
                let (middle, along) = (self.middle(column, row), wall.end - wall.start);
                let t = ((middle - wall.start).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                if (middle - (wall.start + along * t)).norm() < CLEARANCE_M {
                    self.is_free[row * self.columns + column] = false;
                }
            }
        }
    }

    fn middle(&self, column: usize, row: usize) -> Point2<f64> {
        Point2::new(self.min.x + (column as f64 + 0.5) * CELL_M, self.min.y + (row as f64 + 0.5) * CELL_M)
    }

    /// Whether a robot can be at (x, y), meters.
    #[inline]
    #[must_use]
    pub fn contains(&self, x_m: f64, y_m: f64) -> bool {
        let (column, row) = ((x_m - self.min.x) / CELL_M, (y_m - self.min.y) / CELL_M);
        // Not a number is outside as well.
        if !(column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64) {
            return false;
        }
        self.is_free[row as usize * self.columns + column as usize]
    }

    /// Least and largest (x, y) of all walls, meters.
    #[must_use]
    pub fn bounds_m(&self) -> [Point2<f64>; 2] {
        let size = nalgebra::Vector2::new(self.columns as f64, self.rows as f64) * CELL_M;
        [self.min, self.min + size]
    }

    /// Area where a robot can be, square meters.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        self.free.len() as f64 * CELL_M * CELL_M
    }

    /// The free place that belongs to three numbers of [0, 1): evenly spread numbers give evenly spread places. The
    /// first one chooses the cell, the others the place in it. `None` if nothing is free.
    #[must_use]
    pub fn place(&self, choice: f64, in_cell: [f64; 2]) -> Option<Point2<f64>> {
        let last = self.free.len().checked_sub(1)?;
        let index = self.free[((choice * self.free.len() as f64) as usize).min(last)] as usize;
        let corner = self.middle(index % self.columns, index / self.columns);
        Some(Point2::new(corner.x + (in_cell[0] - 0.5) * CELL_M, corner.y + (in_cell[1] - 0.5) * CELL_M))
    }
}
