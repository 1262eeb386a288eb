//! Gray images of a camera that is not calibrated yet.

use visloc_core::{GrayFrame, GrayImage, PictureSource, SkippedInput, SourceError};

/// As [`PictureSource`], in gray: video decoders make gray images for less than color ones.
pub(crate) trait GrayStream {
    fn next_gray(&mut self) -> Option<Result<GrayFrame, SourceError>>;

    fn num_images(&self) -> Option<usize>;

    fn skipped(&self) -> &[SkippedInput];

    fn num_dropped(&self) -> usize;
}

/// Pictures without their color.
pub(crate) struct GrayOf<P>(pub P);

impl<P: PictureSource> GrayStream for GrayOf<P> {
    fn next_gray(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        let next = self.0.next_picture()?;
        Some(next.map(|picture| GrayFrame::new(picture.at, GrayImage::from_rgb(&picture.image))))
    }

    fn num_images(&self) -> Option<usize> {
        self.0.num_pictures()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.0.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.0.num_dropped()
    }
}
