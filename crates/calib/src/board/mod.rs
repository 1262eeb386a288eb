//! The boards that are photographed.

mod aprilgrid;
mod checkerboard;
mod pattern;
mod tag_family;

pub use aprilgrid::AprilGrid;
pub use checkerboard::Checkerboard;
pub use pattern::{Board, BoardError, BoardFrame};
pub use tag_family::{GRID, NUM_CODES, code_of, nearest};
