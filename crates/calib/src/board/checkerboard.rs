//! The checkerboard.

use nalgebra::Point2;

/// A checkerboard. Its frame: origin at the first inner corner, x along the rows, y down the columns; the square before the
/// origin is black.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checkerboard {
    /// Inner corners along x: one less than squares.
    pub columns: usize,
    /// Inner corners along y.
    pub rows: usize,
    /// Side of a square, meters.
    pub square_m: f64,
}

/// White around the squares, as a share of a square.
const MARGIN: f64 = 0.7;

impl Checkerboard {
    pub(super) fn corner_in_board(&self, id: usize) -> Point2<f64> {
        let (column, row) = (id % self.columns, id / self.columns);
        Point2::new(column as f64, row as f64) * self.square_m
    }

    /// Whether a point is black; `None` outside of the board.
    pub(super) fn is_black(&self, point_in_board: &Point2<f64>) -> Option<bool> {
        let (x, y) = (point_in_board.x / self.square_m, point_in_board.y / self.square_m);
        let (right, bottom) = (self.columns as f64, self.rows as f64);
        let is_inside = |margin: f64| {
            x >= -1.0 - margin && y >= -1.0 - margin && x < right + margin && y < bottom + margin
        };
        if !is_inside(MARGIN) {
            return None;
        }
        let is_even = (x.floor() + y.floor()).rem_euclid(2.0) == 0.0;
        Some(is_inside(0.0) && is_even)
    }

    pub(super) fn squares(&self) -> Vec<(Point2<f64>, f64, bool)> {
        let places = (0..=self.rows).flat_map(|j| (0..=self.columns).map(move |i| (i, j)));
        let black = places.filter(|(i, j)| (i + j).is_multiple_of(2));
        let corner = |i: usize| (i as f64 - 1.0) * self.square_m;
        black.map(|(i, j)| (Point2::new(corner(i), corner(j)), self.square_m, true)).collect()
    }

    pub(super) fn bounds_m(&self) -> [Point2<f64>; 2] {
        let outer = 1.0 + MARGIN;
        [
            Point2::new(-outer, -outer) * self.square_m,
            Point2::new((self.columns - 1) as f64 + outer, (self.rows - 1) as f64 + outer) * self.square_m,
        ]
    }
}
