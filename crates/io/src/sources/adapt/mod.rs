//! What a source cannot deliver, made of what it can.

mod calibrated;
mod from_frames;
mod gray;
mod many_cameras;
mod ranged;
mod skipped;
mod until_stopped;

pub use calibrated::{CalibratedFrames, CalibratedImages};
pub(crate) use calibrated::{frames_of_pictures, images_of_gray, images_of_pictures};
pub(crate) use from_frames::{FramePictures, PicturesOfImages};
pub(crate) use gray::{GrayOf, GrayStream};
pub use many_cameras::ManyCameras;
pub(crate) use ranged::Ranged;
pub use until_stopped::UntilStopped;
