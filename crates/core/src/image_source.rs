//! Where the images of one camera come from.

use crate::{GrayImage, SkippedInput, SourceError, Timestamp, geom::Camera};

/// One gray image with its time.
#[derive(Debug, Clone)]
pub struct GrayFrame {
    /// When it was taken.
    pub at: Timestamp,
    /// The image; its size is the camera's.
    pub image: GrayImage,
}

/// Everything that delivers the images of one calibrated camera: a dataset, a folder, a live camera.
pub trait ImageSource {
    /// The camera of all images.
    fn camera(&self) -> &Camera;

    /// The next image in order of time, `None` at the end. After an error there are no more images.
    fn next_image(&mut self) -> Option<Result<GrayFrame, SourceError>>;

    /// How many images there will be, if that is known; those that cannot be read count.
    fn num_images(&self) -> Option<usize> {
        None
    }

    /// What was left out so far.
    fn skipped(&self) -> &[SkippedInput] {
        &[]
    }

    /// How many images of a live source came while nobody was ready for them.
    fn num_dropped(&self) -> usize {
        0
    }
}
