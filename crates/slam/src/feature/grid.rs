//! The best corner of each cell.

use nalgebra::Point2;
use visloc_core::GrayImage;

use super::{detect_fast, detect_graded_fast, fast::FastCorner, shi_tomasi_score};
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

/// The best corner of each free cell, best cells first: clear ones, then faint ones in the cells that have none. The cells of the clear
/// ones are taken afterwards. The threshold of faint ones is not above that of clear ones.
#[must_use]
pub fn detect_corners_twice(
    pyramid: &Pyramid,
    grid: &mut CornerGrid,
    (clear, faint): (CornerSearch, CornerSearch),
) -> Vec<Corner> {
    let num_levels = clear.num_levels.max(faint.num_levels).min(pyramid.num_levels());
    let graded = |level: usize| {
        let mut found = Vec::new();
        detect_graded_fast(pyramid.level(level), (faint.threshold, clear.threshold), &mut found);
        found
    };
    let found: Vec<Vec<(FastCorner, bool)>> = (0..num_levels).map(graded).collect();
    let is_clear = |(corner, is_clear): &(FastCorner, bool)| is_clear.then_some(*corner);
    let mut corners = best_of_cells(pyramid, grid, clear, |level| found[level].iter().filter_map(is_clear));
    for corner in &corners {
        grid.take(grid.cell(&corner.px));
    }
    let all = |level: usize| found[level].iter().map(|(corner, _)| *corner);
    corners.extend(best_of_cells(pyramid, grid, faint, all));
    corners
}

/// The best corner of each free cell, best cells first.
#[must_use]
pub fn detect_corners(pyramid: &Pyramid, grid: &CornerGrid, search: CornerSearch) -> Vec<Corner> {
    best_of_cells(pyramid, grid, search, |level| {
        let mut found: Vec<FastCorner> = Vec::new();
        detect_fast(pyramid.level(level), search.threshold, &mut found);
        found.into_iter()
    })
}

fn best_of_cells<I: Iterator<Item = FastCorner>>(
    pyramid: &Pyramid,
    grid: &CornerGrid,
    search: CornerSearch,
    corners_of: impl Fn(usize) -> I,
) -> Vec<Corner> {
    let mut best: Vec<Option<Corner>> = vec![None; grid.num_cells()];
    for level in 0..search.num_levels.min(pyramid.num_levels()) {
        let image = pyramid.level(level);
        for corner in corners_of(level) {
            let px = px_from_level(&Point2::new(f64::from(corner.x), f64::from(corner.y)), level);
            let cell = grid.cell(&px);
            if grid.is_taken(cell) {
                continue;
            }
            let score = shi_tomasi_score(image, corner.x as usize, corner.y as usize);
            if score >= search.min_score && best[cell].is_none_or(|b| score > b.score) {
                best[cell] = Some(Corner { px, level, score });
            }
        }
    }
    let mut corners: Vec<Corner> = best.into_iter().flatten().collect();
    corners.sort_by(|a, b| b.score.total_cmp(&a.score));
    corners
}
