//! Pictures of boards with known truth.
//!
//! Every pixel is the mean of many rays through the lens onto the board; then come blur, uneven light and noise. Nothing is
//! shared with the detector but the board itself.

mod board;
mod poses;

pub use board::{RenderSettings, render};
pub use poses::random_pose;
