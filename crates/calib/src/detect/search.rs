//! The search over the levels of the pyramid.

use nalgebra::Point2;
use visloc_core::GrayImage;

use super::{BoardCorner, DetectReject, Detection, checkerboard, grow::Corners, subpixel, tag_grid};
use crate::{
    Board,
    saddles::{FloatImage, SaddleIndex, find_saddles},
};

/// Smallest image side, pixels.
const MIN_SIDE_PX: usize = 32;
/// The search begins at the finest level that is not wider than this, pixels: boards fill much of an image.
const FIRST_WIDTH_PX: usize = 1000;
/// Levels above the full image.
const MAX_LEVELS: usize = 4;
/// Radius of the refinement as a share of the distance to the next corner, and its bounds, pixels.
const RADIUS: (f64, f64, f64) = (0.42, 2.0, 12.0);

/// Finds a board. Never panics, whatever the image shows.
///
/// # Errors
/// Why the board was not found.
pub fn detect(board: &Board, image: &GrayImage) -> Result<Detection, DetectReject> {
    if image.width() < MIN_SIDE_PX || image.height() < MIN_SIDE_PX {
        return Err(DetectReject::ImageTooSmall(image.width(), image.height()));
    }
    let mut levels = vec![FloatImage::from_gray(image)];
    while levels.len() < MAX_LEVELS && levels[levels.len() - 1].width() / 2 >= 4 * MIN_SIDE_PX {
        levels.push(levels[levels.len() - 1].half());
    }
    let first = levels.iter().position(|level| level.width() <= FIRST_WIDTH_PX).unwrap_or(levels.len() - 1);
    // First the usual level, then finer ones for small boards, then coarser ones for blurred pictures.
    let order = std::iter::once(first).chain((0..first).rev()).chain(first + 1..levels.len());
    let mut best: Option<Detection> = None;
    let mut reject = None;
    for level in order {
        match find(board, &levels[level]) {
            Ok(numbered) => {
                let found = refined(board, &levels[0], &full_px(&numbered, level));
                let is_better = best.as_ref().is_none_or(|b| found.corners.len() > b.corners.len());
                if is_better {
                    best = Some(found);
                }
            }
            Err(why) => {
                reject.get_or_insert(why);
            }
        }
        if best.as_ref().is_some_and(|b| b.corners.len() * 10 >= board.num_corners() * 9) {
            break;
        }
    }
    let found = best.filter(|b| b.corners.len() >= 6);
    found.ok_or(reject.unwrap_or(DetectReject::NoBoard(0)))
}

fn find(board: &Board, image: &FloatImage) -> Result<Vec<(usize, Point2<f64>)>, DetectReject> {
    let (saddles, smooth) = find_saddles(image);
    let index = SaddleIndex::new(&saddles, image.width(), image.height());
    let corners = Corners { image: &smooth, saddles: &saddles, index: &index };
    match board {
        Board::Checkerboard(board) => checkerboard::find(&corners, board),
        Board::AprilGrid(grid) => tag_grid::find(&corners, grid),
    }
}

/// Places of a level in the full image: a pixel of the next level is the middle of four.
fn full_px(numbered: &[(usize, Point2<f64>)], level: usize) -> Vec<(usize, Point2<f64>)> {
    let scale = f64::from(1_u32 << level.min(8));
    let to_full = |v: f64| (v + 0.5) * scale - 0.5;
    numbered.iter().map(|(id, px)| (*id, Point2::new(to_full(px.x), to_full(px.y)))).collect()
}

/// Refines all corners in the full image; those that run away are left out.
fn refined(board: &Board, image: &FloatImage, numbered: &[(usize, Point2<f64>)]) -> Detection {
    let smooth = image.blurred(0.7);
    let mut corners: Vec<BoardCorner> = numbered
        .iter()
        .filter_map(|(id, px)| {
            let nearest = numbered
                .iter()
                .filter(|(other, _)| other != id)
                .map(|(_, other)| (other - px).norm())
                .fold(f64::INFINITY, f64::min);
            // The black squares beside a tag may be nearer than any corner that is known.
            let nearest = match board {
                Board::AprilGrid(grid) => nearest.min(nearest_of_tag(numbered, *id, px) * grid.spacing),
                Board::Checkerboard(_) => nearest,
            };
            let radius_px = (RADIUS.0 * nearest).clamp(RADIUS.1, RADIUS.2);
            Some(BoardCorner { id: *id, px: subpixel::refine(&smooth, px, radius_px)? })
        })
        .collect();
    corners.sort_by_key(|corner| corner.id);
    Detection { corners }
}

/// Length of the shortest side of a tag at one of its corners, pixels.
fn nearest_of_tag(numbered: &[(usize, Point2<f64>)], id: usize, px: &Point2<f64>) -> f64 {
    let beside = [id / 4 * 4 + (id + 1) % 4, id / 4 * 4 + (id + 3) % 4];
    let of_tag = numbered.iter().filter(|(other, _)| beside.contains(other));
    of_tag.map(|(_, other)| (other - px).norm()).fold(f64::INFINITY, f64::min)
}
