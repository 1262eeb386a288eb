//! Corners.

mod fast;
mod grid;
mod shi_tomasi;

pub use fast::{FastCorner, detect_fast, detect_graded_fast, fast_score};
pub use grid::{Corner, CornerGrid, CornerSearch, detect_corners, gradient_noise};
pub use shi_tomasi::shi_tomasi_score;
