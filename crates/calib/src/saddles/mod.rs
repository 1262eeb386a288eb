//! Saddle points of the brightness, where two black and two white corners meet: found on a pyramid of an image, and by their places.

mod float_image;
mod index;
mod saddle;

pub use float_image::FloatImage;
pub use index::SaddleIndex;
pub use saddle::{Saddle, find_saddles};
