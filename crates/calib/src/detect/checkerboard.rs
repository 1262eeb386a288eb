//! The checkerboard in one level of the pyramid.

use nalgebra::Point2;

use super::{
    DetectReject,
    grow::{Corners, Grid},
    lattice::number,
};
use crate::Checkerboard;

/// So many seeds are tried without a better grid.
const MAX_SEEDS: usize = 60;

/// Numbered corners of a board.
pub(super) fn find(
    corners: &Corners<'_>,
    board: &Checkerboard,
) -> Result<Vec<(usize, Point2<f64>)>, DetectReject> {
    let wanted = board.columns * board.rows;
    let mut best = Grid::new();
    let mut is_used = vec![false; corners.saddles.len()];
    let mut misses = 0;
    // In steps that are spread over the list: the strongest ones may all be clutter.
    for seed in 0..corners.saddles.len() {
        if is_used[seed] {
            continue;
        }
        let grid = corners.grow(seed);
        for saddle in grid.values() {
            is_used[*saddle] = true;
        }
        misses += 1;
        if grid.len() > best.len() {
            best = grid;
            misses = 0;
        }
        if best.len() >= wanted || (misses > MAX_SEEDS && best.len() * 2 > wanted) || misses > 10 * MAX_SEEDS
        {
            break;
        }
    }
    if best.len() < 6 {
        return Err(DetectReject::NoBoard(corners.saddles.len()));
    }
    number(&best, corners.saddles, corners.image, board)
}
