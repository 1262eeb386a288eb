//! Corners of boards in images.
//!
//! Both kinds of boards are made of *saddle points*: places where two black and two white corners meet. Saddle points are found
//! on a pyramid, joined to a grid of squares or to outlines of tags, and refined to a fraction of a pixel in the full image.

mod checkerboard;
mod corner;
mod grow;
mod lattice;
mod search;
mod subpixel;
mod tag_grid;

pub use corner::{BoardCorner, DetectReject, Detection};
pub use search::detect;
