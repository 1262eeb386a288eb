//! Image sequences of datasets.

mod calibration;
mod error;
mod files;
mod tum;

pub use error::SequenceError;
pub use files::{FileSequence, ImageFile, SequenceRange};
pub use tum::{open_tum, read_camera_trajectory, write_camera_trajectory};
