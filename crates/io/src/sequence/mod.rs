//! Image sequences of datasets.
//!
//! [`open_sequence`] recognizes the layout of a folder (TUM RGB-D, ICL-NUIM, EuRoC, Zurich urban MAV, KITTI odometry, a plain folder),
//! reads the dataset's own calibration and truth, and hands out the images as a [`visloc_core::ImageSource`]. A new layout
//! is one file in `layouts/` and its line in the list there.

mod files;
mod layouts;
mod open;
mod pictures;
mod range;

pub use files::{FileSequence, ImageFile};
pub use layouts::{image_files, instead_of_images, is_image};
pub(crate) use open::resized;
pub use open::{
    Listing, MOST_SLAM_SIDE_PX, SCALES, Sequence, SequenceOptions, fit_calibration, list_sequence,
    open_sequence, open_tum, sequence_layouts,
};
pub use pictures::FilePictures;
pub use range::{Bound, InRange, RangeJudge, SequenceRange};

pub use crate::{
    camera_file::{Calibration, read_calibration},
    camera_trajectory::{read_camera_trajectory, write_camera_trajectory},
};
