//! The best corner of each cell.

use std::ops::Range;

use nalgebra::Point2;
use visloc_core::GrayImage;

use super::{detect_graded_fast, shi_tomasi_score};
use crate::image::{Pyramid, px_from_level};

/// A corner of some level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Position in the pixels of level 0.
    pub px: Point2<f64>,
    /// Level on which it was found.
    pub level: usize,
    /// Shi-Tomasi score, comparable over levels.
    pub score: f32,
}

/// Cells over an image, each free or taken.
#[derive(Debug, Clone)]
pub struct CornerGrid {
    cell_px: f64,
    columns: usize,
    rows: usize,
    is_taken: Vec<bool>,
}

impl CornerGrid {
    /// A free grid over an image of the given size, pixels.
    #[must_use]
    pub fn new(size_px: (u32, u32), cell_px: f64) -> Self {
        let count = |side: u32| (f64::from(side) / cell_px).ceil().max(1.0) as usize;
        let (columns, rows) = (count(size_px.0), count(size_px.1));
        Self { cell_px, columns, rows, is_taken: vec![false; columns * rows] }
    }

    /// Index of the cell of a pixel of level 0; pixels outside belong to the nearest cell.
    #[must_use]
    pub fn cell(&self, px: &Point2<f64>) -> usize {
        let index =
            |v: f64, count: usize| ((v + 0.5) / self.cell_px).max(0.0).min(count as f64 - 1.0) as usize;
        index(px.y, self.rows) * self.columns + index(px.x, self.columns)
    }

    /// How many cells there are.
    #[must_use]
    pub fn num_cells(&self) -> usize {
        self.is_taken.len()
    }

    /// Marks a cell; says whether it was free.
    pub fn take(&mut self, cell: usize) -> bool {
        !std::mem::replace(&mut self.is_taken[cell], true)
    }

    /// Whether a cell is taken.
    #[must_use]
    pub fn is_taken(&self, cell: usize) -> bool {
        self.is_taken[cell]
    }

    /// For each row of cells the columns of a level's pixels that belong to free cells, from left to right.
    fn free_columns(&self, cell_of_column: &[usize]) -> Vec<Vec<Range<usize>>> {
        let free = |row: &[bool]| {
            let mut ranges: Vec<Range<usize>> = Vec::new();
            for (x, _) in cell_of_column.iter().enumerate().filter(|(_, cell)| !row[**cell]) {
                match ranges.last_mut() {
                    Some(range) if range.end == x => range.end += 1,
                    _ => ranges.push(x..x + 1),
                }
            }
            ranges
        };
        self.is_taken.chunks_exact(self.columns).map(free).collect()
    }

    /// The column of cells of each column of a level's pixels, and the row of each row.
    fn cells_of_level(&self, image: &GrayImage, level: usize) -> (Vec<usize>, Vec<usize>) {
        let cell = |x: usize, y: usize| self.cell(&px_from_level(&Point2::new(x as f64, y as f64), level));
        let columns = (0..image.width()).map(|x| cell(x, 0) % self.columns).collect();
        (columns, (0..image.height()).map(|y| cell(0, y) / self.columns).collect())
    }
}

/// How corners are searched.
#[derive(Debug, Clone, Copy)]
pub struct CornerSearch {
    /// Levels that are searched, from 0.
    pub num_levels: usize,
    /// FAST threshold, gray levels.
    pub threshold: u8,
    /// Least Shi-Tomasi score.
    pub min_score: f32,
}

/// Most that a camera's noise can be, (gray levels per pixel)^2; above, it is fine texture.
const MOST_NOISE: f32 = 10.0;

/// Shi-Tomasi score that noise alone reaches on each level, which is the mean squared gradient of noise: the lower quartile
/// over a regular sample of pixels.
#[must_use]
pub fn gradient_noise(pyramid: &Pyramid, num_levels: usize) -> Vec<f32> {
    (0..num_levels.min(pyramid.num_levels())).map(|level| gradient_noise_of(pyramid.level(level))).collect()
}

fn gradient_noise_of(image: &GrayImage) -> f32 {
    let step = if image.width() > 400 { 16 } else { 8 };
    let places = |side: usize| (8..side.saturating_sub(8)).step_by(step);
    let mut scores: Vec<f32> = places(image.height())
        .flat_map(|y| places(image.width()).map(move |x| (x, y)))
        .map(|(x, y)| shi_tomasi_score(image, x, y))
        .collect();
    scores.sort_by(f32::total_cmp);
    scores.get(scores.len() / 4).copied().unwrap_or(0.0).min(MOST_NOISE)
}

/// The best corner of each free cell, best cells first: clear ones, then faint ones in the cells that have none. Both are searched on the
/// levels of the clear ones, and the threshold of faint ones is not above that of clear ones.
#[must_use]
pub fn detect_corners(
    pyramid: &Pyramid,
    grid: &CornerGrid,
    (clear, faint): (CornerSearch, CornerSearch),
) -> Vec<Corner> {
    let mut best: Vec<(Option<Corner>, Option<Corner>)> = vec![(None, None); grid.num_cells()];
    for level in 0..clear.num_levels.min(pyramid.num_levels()) {
        let image = pyramid.level(level);
        let (columns, rows) = grid.cells_of_level(image, level);
        let free = grid.free_columns(&columns);
        let free = |y: usize| free[rows[y]].as_slice();
        detect_graded_fast(image, (faint.threshold, clear.threshold), free, |corner, is_clear| {
            let (x, y) = (corner.x as usize, corner.y as usize);
            let (best_clear, best_faint) = &mut best[rows[y] * grid.columns + columns[x]];
            if best_clear.is_some() && !is_clear {
                return;
            }
            let score = shi_tomasi_score(image, x, y);
            let is_best = |best: &Option<Corner>| best.is_none_or(|b| score > b.score);
            let px = px_from_level(&Point2::new(x as f64, y as f64), level);
            let corner = Corner { px, level, score };
            if is_clear && score >= clear.min_score && is_best(best_clear) {
                *best_clear = Some(corner);
            }
            if score >= faint.min_score && is_best(best_faint) {
                *best_faint = Some(corner);
            }
        });
    }
    let mut corners = best_first(best.iter().filter_map(|(clear, _)| *clear));
    corners.extend(best_first(best.iter().filter_map(|(clear, faint)| faint.filter(|_| clear.is_none()))));
    corners
}

fn best_first(corners: impl Iterator<Item = Corner>) -> Vec<Corner> {
    let mut corners: Vec<Corner> = corners.collect();
    corners.sort_by(|a, b| b.score.total_cmp(&a.score));
    corners
}
