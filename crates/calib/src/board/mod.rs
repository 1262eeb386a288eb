//! The boards that are photographed.

mod aprilgrid;
mod checkerboard;
mod pattern;

pub use aprilgrid::AprilGrid;
pub use checkerboard::Checkerboard;
pub use pattern::{Board, BoardError, BoardFrame};
