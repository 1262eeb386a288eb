//! Nearest-outline tables: for every cell of the ground, which outlines are nearest.
//!
//! Source: 2010 section 4.3.1, a grid of 2.5 cm. Deviations: a cell holds the nearest outlines, not the nearest point,
//! and the nearest point on an outline is then exact: this removes the grid's rounding, up to 10 pixels near the robot.
//! And it holds those of the two nearest marks, since what is nearest on the ground need not be nearest in the image.
//! Building takes a few milliseconds, so nothing is cached on disk.

use nalgebra::{Point2, Vector2};

use super::outline::Outline;

/// Size of a cell, meters.
const CELL_M: f64 = 0.025;

#[derive(Debug, Clone)]
pub(super) struct NearestTable {
    outlines: Vec<Outline>,
    /// Indices of the nearest outline, and of the nearest outline of any other mark, row by row.
    cells: Vec<[u8; 2]>,
    min: Point2<f64>,
    columns: usize,
    rows: usize,
}

impl NearestTable {
    /// The table of a rectangle of the ground. `marks` are the outlines of each mark. For points outside of the
    /// rectangle the outlines of its nearest point are taken, so the table should reach beyond the outlines.
    ///
    /// # Panics
    /// If there are no outlines or more than 256.
    pub fn new(marks: &[Vec<Outline>], min: Point2<f64>, max: Point2<f64>) -> Self {
        let outlines: Vec<Outline> = marks.iter().flatten().copied().collect();
        assert!((1..=256).contains(&outlines.len()), "a table holds 1 to 256 outlines");
        let columns = ((max.x - min.x) / CELL_M).ceil().max(1.0) as usize;
        let rows = ((max.y - min.y) / CELL_M).ceil().max(1.0) as usize;
        let mut cells = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let center =
                    Point2::new(min.x + (column as f64 + 0.5) * CELL_M, min.y + (row as f64 + 0.5) * CELL_M);
                cells.push(nearest_outlines(marks, &center));
            }
        }
        Self { outlines, cells, min, columns, rows }
    }

    /// The nearest point, with the outline's direction there, on each of the outlines that are nearest to a point.
    #[inline]
    pub fn nearest_points(
        &self,
        point: &Point2<f64>,
        [first, second]: [u8; 2],
    ) -> [(Point2<f64>, Vector2<f64>); 2] {
        [self.outline(first).nearest_point(point), self.outline(second).nearest_point(point)]
    }

    /// An outline and the opposite border of the same strip.
    #[inline]
    pub fn both_borders(&self, index: u8) -> [&Outline; 2] {
        [self.outline(index), self.outline(index ^ 1)]
    }

    #[inline]
    fn outline(&self, index: u8) -> &Outline {
        &self.outlines[usize::from(index)]
    }

    /// The nearest outline of each of the two nearest marks.
    #[inline]
    pub fn nearest_indices(&self, point: &Point2<f64>) -> [u8; 2] {
        // A cast of a float saturates, so points far outside land on the border cells.
        let column = (((point.x - self.min.x) * (1.0 / CELL_M)) as usize).min(self.columns - 1);
        let row = (((point.y - self.min.y) * (1.0 / CELL_M)) as usize).min(self.rows - 1);
        self.cells[row * self.columns + column]
    }

    pub fn outlines(&self) -> &[Outline] {
        &self.outlines
    }
}

fn nearest_outlines(marks: &[Vec<Outline>], point: &Point2<f64>) -> [u8; 2] {
    let mut nearest = [(f64::INFINITY, 0), (f64::INFINITY, 0)];
    let mut index = 0;
    for mark in marks {
        let mut of_mark = (f64::INFINITY, 0);
        for outline in mark {
            let distance2 = (outline.nearest_point(point).0 - point).norm_squared();
            if distance2 < of_mark.0 {
                of_mark = (distance2, index as u8);
            }
            index += 1;
        }
        if of_mark.0 < nearest[0].0 {
            nearest = [of_mark, nearest[0]];
        } else if of_mark.0 < nearest[1].0 {
            nearest[1] = of_mark;
        }
    }
    if marks.len() < 2 {
        nearest[1] = nearest[0];
    }
    nearest.map(|(_, i)| i)
}

#[cfg(test)]
mod tests {
    use visloc_world::Map;

    use super::*;
    use crate::observation::field::outline::ground_outlines;

    fn nearest_points(table: &NearestTable, point: &Point2<f64>) -> [(Point2<f64>, Vector2<f64>); 2] {
        table.nearest_points(point, table.nearest_indices(point))
    }

    fn table() -> (Vec<Vec<Outline>>, NearestTable) {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2010") else { panic!("built-in map") };
        let marks = ground_outlines(&field);
        let table = NearestTable::new(&marks, Point2::new(-3.7, -2.7), Point2::new(3.7, 2.7));
        (marks, table)
    }

    #[test]
    fn table_agrees_with_a_search_over_all_outlines() {
        let (marks, table) = table();
        let mut worst: f64 = 0.0;
        for i in 0..200 {
            for j in 0..150 {
                let point = Point2::new(-3.6 + f64::from(i) * 0.0361, -2.6 + f64::from(j) * 0.0347);
                let distance = |q: Point2<f64>| (q - point).norm();
                let outlines = marks.iter().flatten();
                let exact =
                    outlines.map(|o| distance(o.nearest_point(&point).0)).fold(f64::INFINITY, f64::min);
                let [first, second] = nearest_points(&table, &point).map(|(nearest, _)| distance(nearest));
                worst = worst.max(first.min(second) - exact);
            }
        }
        // Only cells on the border between two outlines may answer with the second nearest.
        assert!(worst < CELL_M * 1.5, "{worst}");
    }

    #[test]
    fn the_two_answers_are_on_different_marks() {
        let (_, table) = table();
        // in the corner of goal line (x = -3) and side line (y = 2), nearer to the goal line
        let [first, second] = nearest_points(&table, &Point2::new(-2.7, 1.6)).map(|(nearest, _)| nearest);
        assert!((first - Point2::new(-2.975, 1.6)).norm() < 1e-9, "{first}");
        assert!((second - Point2::new(-2.7, 1.975)).norm() < 1e-9, "{second}");
    }

    #[test]
    fn points_far_outside_are_answered() {
        let (_, table) = table();
        let (nearest, _) = nearest_points(&table, &Point2::new(-50.0, 0.0))[0];
        assert!((nearest.x + 3.025).abs() < 1e-9 && nearest.y.abs() < 1e-9, "{nearest}");
    }
}
