//! Where pictures come from when nothing else is known: no calibration, no robot.

use crate::{RgbImage, SkippedInput, SourceError, Timestamp};

/// One color image with its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// When it was taken.
    pub at: Timestamp,
    /// The image.
    pub image: RgbImage,
}

/// Everything that delivers pictures: a folder, a video, a webcam, a recording, a topic.
///
/// A *recorded* source waits for whoever reads it. A *live* one does not: what comes while nobody reads is dropped except
/// for the newest picture, and counted.
pub trait PictureSource {
    /// The next picture in order of time, `None` at the end. After an error there are no more pictures.
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>>;

    /// The file of the last picture as it stands in the source, JPEG or PNG; `None` if it was no file.
    fn original(&self) -> Option<&[u8]> {
        None
    }

    /// How many pictures there will be, if that is known; those that cannot be read count.
    fn num_pictures(&self) -> Option<usize> {
        None
    }

    /// What was left out so far.
    fn skipped(&self) -> &[SkippedInput] {
        &[]
    }

    /// How many pictures of a live source came while nobody was ready for them.
    fn num_dropped(&self) -> usize {
        0
    }
}

impl<P: PictureSource + ?Sized> PictureSource for Box<P> {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        (**self).next_picture()
    }

    fn original(&self) -> Option<&[u8]> {
        (**self).original()
    }

    fn num_pictures(&self) -> Option<usize> {
        (**self).num_pictures()
    }

    fn skipped(&self) -> &[SkippedInput] {
        (**self).skipped()
    }

    fn num_dropped(&self) -> usize {
        (**self).num_dropped()
    }
}
