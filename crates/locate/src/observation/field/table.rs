//! Nearest-outline tables: for every cell of a plane, which outline is nearest.
//!
//! Source: 2010 section 4.3.1, a grid of 2.5 cm. Deviation: a cell holds the nearest outline, not the nearest point;
//! the nearest point on that one outline is then exact. This removes the grid's rounding (a cell is up to 10 pixels
//! near the robot) at the cost of a few multiplications. Building takes a few milliseconds, so nothing is cached on
//! disk.

use nalgebra::Point2;

use super::outline::Outline;

/// Size of a cell, meters.
const CELL_M: f64 = 0.025;

#[derive(Debug, Clone)]
pub(super) struct NearestTable {
    outlines: Vec<Outline>,
    /// Index of the nearest outline, row by row.
    cells: Vec<u8>,
    min: Point2<f64>,
    columns: usize,
    rows: usize,
}

impl NearestTable {
    /// The table of a rectangle of a plane. Points outside are treated as the nearest point of the rectangle when the
    /// outline is chosen, so the table should reach beyond the outlines.
    ///
    /// # Panics
    /// If there are no outlines or more than 256.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    pub fn new(outlines: Vec<Outline>, min: Point2<f64>, max: Point2<f64>) -> Self {
        assert!((1..=256).contains(&outlines.len()), "a table holds 1 to 256 outlines");
        let columns = ((max.x - min.x) / CELL_M).ceil().max(1.0) as usize;
        let rows = ((max.y - min.y) / CELL_M).ceil().max(1.0) as usize;
        let mut cells = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let center =
                    Point2::new(min.x + (column as f64 + 0.5) * CELL_M, min.y + (row as f64 + 0.5) * CELL_M);
                cells.push(nearest_outline(&outlines, &center));
            }
        }
        Self { outlines, cells, min, columns, rows }
    }

    /// The nearest point on any outline.
    #[inline]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn nearest_point(&self, point: &Point2<f64>) -> Point2<f64> {
        // A cast of a float saturates, so points far outside land on the border cells.
        let column = (((point.x - self.min.x) * (1.0 / CELL_M)) as usize).min(self.columns - 1);
        let row = (((point.y - self.min.y) * (1.0 / CELL_M)) as usize).min(self.rows - 1);
        self.outlines[usize::from(self.cells[row * self.columns + column])].nearest_point(point)
    }

    pub fn outlines(&self) -> &[Outline] {
        &self.outlines
    }
}

#[allow(clippy::cast_possible_truncation)]
fn nearest_outline(outlines: &[Outline], point: &Point2<f64>) -> u8 {
    let mut best = (f64::INFINITY, 0);
    for (i, outline) in outlines.iter().enumerate() {
        let distance2 = (outline.nearest_point(point) - point).norm_squared();
        if distance2 < best.0 {
            best = (distance2, i);
        }
    }
    best.1 as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::field::outline::ground_outlines;
    use visloc_world::Map;

    #[test]
    fn table_agrees_with_a_search_over_all_outlines() {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2010") else { panic!("built-in map") };
        let outlines = ground_outlines(&field);
        let table = NearestTable::new(outlines.clone(), Point2::new(-3.7, -2.7), Point2::new(3.7, 2.7));
        let mut worst: f64 = 0.0;
        for i in 0..200 {
            for j in 0..150 {
                let point = Point2::new(-3.6 + f64::from(i) * 0.0361, -2.6 + f64::from(j) * 0.0347);
                let distance = |q: Point2<f64>| (q - point).norm();
                let exact =
                    outlines.iter().map(|o| distance(o.nearest_point(&point))).fold(f64::INFINITY, f64::min);
                worst = worst.max(distance(table.nearest_point(&point)) - exact);
            }
        }
        // Only cells on the border between two outlines may answer with the second nearest.
        assert!(worst < CELL_M * 1.5, "{worst}");
    }

    #[test]
    fn points_far_outside_are_answered() {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2010") else { panic!("built-in map") };
        let table =
            NearestTable::new(ground_outlines(&field), Point2::new(-3.7, -2.7), Point2::new(3.7, 2.7));
        let nearest = table.nearest_point(&Point2::new(-50.0, 0.0));
        assert!((nearest.x + 3.025).abs() < 1e-9 && nearest.y.abs() < 1e-9, "{nearest}");
    }
}
