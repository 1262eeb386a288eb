//! Images at several resolutions, and between their pixels.

mod pyramid;
mod sample;

pub use pyramid::{Pyramid, level_from_px, px_from_level};
pub(crate) use pyramid::{doubled, halved};
pub use sample::sample_square;
