//! Images at several resolutions.

mod pyramid;
mod small;

pub use pyramid::{Pyramid, level_from_px, px_from_level};
pub use small::SmallImage;
