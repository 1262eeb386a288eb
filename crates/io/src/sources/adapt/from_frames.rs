//! Pictures and gray images of a source that delivers more.

use visloc_core::{
    FrameSource, GrayFrame, ImageSource, Picture, PictureSource, SkippedInput, SourceError, SourceFrame,
    geom::Camera,
};

use super::GrayStream;
use crate::sources::video::in_color;

/// The pictures of a robot's camera. The camera is that of the first frame.
pub(crate) struct FramePictures {
    frames: Box<dyn FrameSource>,
    first: Option<SourceFrame>,
    camera: Camera,
}

impl FramePictures {
    /// Reads the first frame; `None` if there is none.
    pub(crate) fn new(mut frames: Box<dyn FrameSource>) -> Option<Result<Self, SourceError>> {
        let first = match frames.next_frame()? {
            Ok(first) => first,
            Err(error) => return Some(Err(error)),
        };
        Some(Ok(Self { frames, camera: first.frame.camera, first: Some(first) }))
    }

    pub(crate) fn camera(&self) -> &Camera {
        &self.camera
    }
}

impl PictureSource for FramePictures {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        let next = self.first.take().map(Ok).or_else(|| self.frames.next_frame())?;
        Some(next.map(|SourceFrame { frame, .. }| Picture { at: frame.at, image: frame.image }))
    }

    fn num_pictures(&self) -> Option<usize> {
        self.frames.num_frames()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.frames.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.frames.num_dropped()
    }
}

/// The gray images of a robot's camera, with what its odometry says of it.
impl GrayStream for FramePictures {
    fn next_gray(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        let next = self.first.take().map(Ok).or_else(|| self.frames.next_frame())?;
        Some(next.map(GrayFrame::of_robot))
    }

    fn num_images(&self) -> Option<usize> {
        self.frames.num_frames()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.frames.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.frames.num_dropped()
    }
}

/// Gray images as pictures.
pub(crate) struct PicturesOfImages(pub Box<dyn ImageSource>);

impl PictureSource for PicturesOfImages {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        Some(self.0.next_image()?.map(|frame| Picture { at: frame.at, image: in_color(&frame.image) }))
    }

    fn num_pictures(&self) -> Option<usize> {
        self.0.num_images()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.0.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.0.num_dropped()
    }
}
