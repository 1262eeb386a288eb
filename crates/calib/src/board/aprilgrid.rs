//! The grid of AprilTags.

use nalgebra::Point2;

use super::{GRID, code_of};

/// A grid of tags of the family tag36h11 with black squares in the gaps, which touch the corners of the tags: the target of
/// Kalibr. Its frame: origin at the outer corner of the tag with the lowest number, x along the numbers, y towards the next
/// row of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AprilGrid {
    /// Tags along x.
    pub columns: usize,
    /// Tags along y.
    pub rows: usize,
    /// Side of a tag with its black border, meters.
    pub tag_m: f64,
    /// Gap between tags as a share of a tag's side.
    pub spacing: f64,
    /// Number of the first tag.
    pub first_id: usize,
    /// Width of a tag's black border, cells of the code: 2 on boards of Kalibr, 1 on plain tags.
    pub border_cells: usize,
}

impl AprilGrid {
    /// From the edge of a tag to the same edge of the next, meters.
    pub fn pitch_m(&self) -> f64 {
        self.tag_m * (1.0 + self.spacing)
    }

    /// Corners of tag n are 4 n to 4 n + 3: at the origin's side, along x, opposite, along y.
    pub(super) fn corner_in_board(&self, id: usize) -> Point2<f64> {
        let (tag, corner) = (id / 4, id % 4);
        let (column, row) = (tag % self.columns, tag / self.columns);
        let right = if corner == 1 || corner == 2 { self.tag_m } else { 0.0 };
        let down = if corner >= 2 { self.tag_m } else { 0.0 };
        Point2::new(column as f64 * self.pitch_m() + right, row as f64 * self.pitch_m() + down)
    }

    /// Whether a point is black; `None` outside of the board.
    pub(super) fn is_black(&self, point_in_board: &Point2<f64>) -> Option<bool> {
        let [low, high] = self.bounds_m();
        let p = point_in_board;
        if p.x < low.x || p.y < low.y || p.x >= high.x || p.y >= high.y {
            return None;
        }
        let (pitch, gap) = (self.pitch_m(), self.tag_m * self.spacing);
        // Of the cell that begins with the gap before a tag.
        let (column, row) = (((p.x + gap) / pitch).floor(), ((p.y + gap) / pitch).floor());
        let (x, y) = (p.x - column * pitch, p.y - row * pitch);
        if x < 0.0 && y < 0.0 {
            let is_corner =
                column >= 0.0 && row >= 0.0 && column <= self.columns as f64 && row <= self.rows as f64;
            return Some(is_corner);
        }
        if x < 0.0 || y < 0.0 {
            return Some(false);
        }
        self.is_black_in_tag(column, row, (x / self.tag_m, y / self.tag_m))
    }

    /// `x` and `y` from 0 to 1 across the tag.
    fn is_black_in_tag(&self, column: f64, row: f64, (x, y): (f64, f64)) -> Option<bool> {
        if column < 0.0 || row < 0.0 || column >= self.columns as f64 || row >= self.rows as f64 {
            return Some(false);
        }
        let num_cells = GRID + 2 * self.border_cells;
        let cell = |share: f64| ((share * num_cells as f64) as usize).checked_sub(self.border_cells);
        let (Some(i), Some(j)) = (cell(x), cell(y)) else { return Some(true) };
        if i >= GRID || j >= GRID {
            return Some(true);
        }
        let code = code_of(self.first_id + row as usize * self.columns + column as usize)?;
        Some(code >> (GRID * GRID - 1 - (j * GRID + i)) & 1 == 0)
    }

    pub(super) fn squares(&self) -> Vec<(Point2<f64>, f64, bool)> {
        let (pitch, gap) = (self.pitch_m(), self.tag_m * self.spacing);
        let mut squares = Vec::new();
        for (column, row) in
            (0..=self.rows).flat_map(|j| (0..=self.columns).map(move |i| (i as f64, j as f64)))
        {
            squares.push((Point2::new(column * pitch - gap, row * pitch - gap), gap, true));
        }
        let cell_m = self.tag_m / (GRID + 2 * self.border_cells) as f64;
        for tag in 0..self.columns * self.rows {
            let at = self.corner_in_board(4 * tag);
            squares.push((at, self.tag_m, true));
            let code = code_of(self.first_id + tag).unwrap_or_default();
            for bit in (0..GRID * GRID).filter(|bit| code >> (GRID * GRID - 1 - bit) & 1 == 1) {
                let cell = |i: usize| (i + self.border_cells) as f64 * cell_m;
                let offset = nalgebra::Vector2::new(cell(bit % GRID), cell(bit / GRID));
                squares.push((at + offset, cell_m, false));
            }
        }
        squares
    }

    pub(super) fn bounds_m(&self) -> [Point2<f64>; 2] {
        let outer = self.tag_m * (self.spacing + 0.3);
        let side = |count: usize| (count - 1) as f64 * self.pitch_m() + self.tag_m + outer;
        [Point2::new(-outer, -outer), Point2::new(side(self.columns), side(self.rows))]
    }
}
