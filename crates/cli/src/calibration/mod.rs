//! Calibrating a camera: the pictures, the result in words, in files and in pictures.

mod by_hand;
mod by_motion;
mod detections;
mod pictures;
mod report;
mod source;
mod words;

pub use by_hand::{Start, by_hand_page};
pub use by_motion::{calibrate_by_motion, open_images_or_find_camera};
pub use detections::{Detected, find_boards};
pub use pictures::draw;
pub use report::{CalibrationReport, camera_toml, markdown};
pub use source::{NamedImage, NamedImages, OF_BOARD, end, open_images};
pub use words::print;
