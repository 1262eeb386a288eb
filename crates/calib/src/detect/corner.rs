//! What is found, and why nothing is.

use nalgebra::Point2;
use thiserror::Error;

/// A corner of the board in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardCorner {
    /// Number of the corner on the board.
    pub id: usize,
    /// Where it is seen, pixels.
    pub px: Point2<f64>,
}

/// The board in an image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Detection {
    /// In the order of their numbers.
    pub corners: Vec<BoardCorner>,
}

/// Why a board was not found.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DetectReject {
    /// The image has fewer pixels than a board needs.
    #[error("expected an image of at least 32 x 32 px, found {0} x {1} px")]
    ImageTooSmall(usize, usize),
    /// No squares that touch.
    #[error(
        "no board: found {0} places where four squares meet, none of them in a grid; is it sharp and lit?"
    )]
    NoBoard(usize),
    /// The grid has another size.
    #[error(
        "expected a grid of {expected_columns} x {expected_rows} inner corners, found {columns} x {rows}; is --size right, and is \
         the whole board in the picture?"
    )]
    OtherSize {
        /// Inner corners along x that the board has.
        expected_columns: usize,
        /// Inner corners along y that the board has.
        expected_rows: usize,
        /// The longer side that was found.
        columns: usize,
        /// The shorter side that was found.
        rows: usize,
    },
    /// The grid has the right size but too many corners are covered.
    #[error("expected at least half of the {expected} corners, found {found}; is the board covered?")]
    Covered {
        /// Corners of the board.
        expected: usize,
        /// Corners that were found.
        found: usize,
    },
    /// Too few tags to tell how the board lies.
    #[error("expected 4 tags of the grid or more, not all in one row, found {0}")]
    FewTags(usize),
}
