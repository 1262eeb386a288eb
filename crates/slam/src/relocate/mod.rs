//! Finding the camera again in a map.

mod relocator;

pub use relocator::Relocator;
