//! Small cells of an image that do not have the carpet's color, counted in boxes.

use std::ops::Range;

use visloc_core::RgbImage;

use crate::vision::color::{ColorClass, ColorTable};

/// Cells across the image: a ball of 10 cm at 3 m is six of them wide in a view of 46 degrees.
const CELLS_ACROSS: u32 = 160;
/// Probability that a cell of a robot or a ball does not have the carpet's color, and that one of the ground does not: a line.
const OBJECT_IS_OTHER: f64 = 0.85;
pub(super) const GROUND_IS_OTHER: f64 = 0.1;
/// Neighboring cells err alike: those of a part count as so many independent ones at most.
const MAX_INDEPENDENT: f64 = 20.0;

/// Cells that do not have the carpet's color, summed up from the upper left corner.
#[derive(Debug, Default)]
pub(super) struct CellSums {
    /// Side of a cell, pixels.
    pub cell_px: u32,
    /// Cells of a row of the image.
    pub width: usize,
    /// The first row of cells that is looked at, and the end of the last one.
    pub first_row: usize,
    pub height: usize,
    sums: Vec<u32>,
    is_other: Vec<bool>,
}

impl CellSums {
    /// Looks at the middle of each cell below `first_row_px`.
    pub fn fill(&mut self, image: &RgbImage, table: &ColorTable, first_row_px: f64) {
        self.cell_px = (image.width() / CELLS_ACROSS).max(1);
        self.width = (image.width() / self.cell_px) as usize;
        self.height = (image.height() / self.cell_px) as usize;
        self.first_row = cell(first_row_px / f64::from(self.cell_px), self.height);
        let num_rows = self.height - self.first_row;
        self.sums.clear();
        self.sums.resize((self.width + 1) * (num_rows + 1), 0);
        self.is_other.clear();
        let half = self.cell_px / 2;
        for row in 0..num_rows {
            let y = (row + self.first_row) as u32 * self.cell_px + half;
            let pixels = image.row(y)[3 * half as usize..].chunks(3 * self.cell_px as usize);
            let is_other = |px: &[u8]| table.class(px[0], px[1], px[2]) != ColorClass::Green;
            self.is_other.extend(pixels.take(self.width).map(is_other));
            let mut in_row = 0;
            let (above, below) = self.sums[row * (self.width + 1)..].split_at_mut(self.width + 1);
            let of_row = &self.is_other[row * self.width..];
            for ((sum, above), is_other) in below[1..].iter_mut().zip(&above[1..]).zip(of_row) {
                in_row += u32::from(*is_other);
                *sum = above + in_row;
            }
        }
    }

    /// Color of the middle of a cell.
    pub fn color(&self, image: &RgbImage, column: usize, row: usize) -> [u8; 3] {
        let px = |cell: usize| cell as u32 * self.cell_px + self.cell_px / 2;
        image.get(px(column), px(row))
    }

    pub fn is_other(&self, column: usize, row: usize) -> bool {
        self.is_other[(row - self.first_row) * self.width + column]
    }

    /// Column and row of the lowest cell of each thing: below it is carpet.
    pub fn feet(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let rows = self.is_other.chunks_exact(self.width.max(1));
        let pairs = rows.clone().zip(rows.skip(1)).enumerate();
        pairs.flat_map(move |(i, (row, below))| {
            let is_foot = row.iter().zip(below).map(|(is_other, below)| *is_other && !below);
            is_foot
                .enumerate()
                .filter(|(_, is_foot)| *is_foot)
                .map(move |(column, _)| (column, self.first_row + i))
        })
    }

    /// Log of how much better the cells of a box fit an object than the ground; `None` if the box is outside of the image.
    pub fn nats(&self, columns: &Range<f64>, rows: &Range<f64>) -> Option<f64> {
        let (left, right) = (cell(columns.start, self.width), cell(columns.end, self.width));
        let row = |row: f64| cell(row - self.first_row as f64, self.height - self.first_row);
        let (top, bottom) = (row(rows.start), row(rows.end));
        let num = ((right - left.min(right)) * (bottom - top.min(bottom))) as f64;
        if num == 0.0 {
            return None;
        }
        let sum = |row: usize, column: usize| self.sums[row * (self.width + 1) + column];
        let num_other = sum(bottom, right) + sum(top, left) - sum(top, right) - sum(bottom, left);
        Some(log_ratio((f64::from(num_other), num), OBJECT_IS_OTHER, GROUND_IS_OTHER))
    }
}

/// Log of how much more probable it is that so many of all cells show something if each does with the first probability than with the second one.
pub(super) fn log_ratio((num_showing, num): (f64, f64), probability: f64, other: f64) -> f64 {
    let share = num_showing / num;
    let mean =
        share * (probability / other).ln() + (1.0 - share) * ((1.0 - probability) / (1.0 - other)).ln();
    mean * num.min(MAX_INDEPENDENT)
}

/// The nearest border between cells.
pub(super) fn cell(value: f64, end: usize) -> usize {
    // What is negative becomes 0.
    ((value + 0.5) as usize).min(end)
}
