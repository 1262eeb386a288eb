//! What a source cannot deliver, made of what it can.

mod convert;
mod many_cameras;
mod ranged;
mod same_size;
mod until_stopped;

use visloc_core::{GrayFrame, Picture, SourceFrame, Timestamp};

pub(crate) use convert::{
    CameraFrames, frames_in_range, frames_of_pictures, gray_of_frames, images_of_gray, images_of_pictures,
    pictures_in_range, pictures_of_frames, pictures_of_images,
};
pub use many_cameras::ManyCameras;
pub use until_stopped::UntilStopped;

/// An image with its time.
trait Shot {
    fn at(&self) -> Timestamp;

    /// Width and height, pixels.
    fn size_px(&self) -> (u32, u32);
}

impl Shot for Picture {
    fn at(&self) -> Timestamp {
        self.at
    }

    fn size_px(&self) -> (u32, u32) {
        (self.image.width(), self.image.height())
    }
}

impl Shot for SourceFrame {
    fn at(&self) -> Timestamp {
        self.frame.at
    }

    fn size_px(&self) -> (u32, u32) {
        (self.frame.image.width(), self.frame.image.height())
    }
}

impl Shot for GrayFrame {
    fn at(&self) -> Timestamp {
        self.at
    }

    fn size_px(&self) -> (u32, u32) {
        (self.image.width() as u32, self.image.height() as u32)
    }
}
