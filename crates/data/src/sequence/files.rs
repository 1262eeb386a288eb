//! A sequence whose images are files.

use std::path::PathBuf;

use visloc_base::{GrayFrame, ImageSource, SkippedInput, SourceError, Timestamp};
use visloc_geom::Camera;

use crate::image_codec::read_gray_image;

/// An image that is still on the disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFile {
    /// When it was taken.
    pub at: Timestamp,
    /// Where it is.
    pub path: PathBuf,
}

/// Which images of a sequence are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceRange {
    /// First image, from 0.
    pub start: usize,
    /// One past the last image; `None` for all.
    pub end: Option<usize>,
    /// Every how manyeth image; at least 1 is used.
    pub stride: usize,
}

impl Default for SequenceRange {
    /// All images.
    fn default() -> Self {
        Self { start: 0, end: None, stride: 1 }
    }
}

/// Reads images one after another. One that is missing, damaged or of another size is left out and noted.
#[derive(Debug)]
pub struct FileSequence {
    camera: Camera,
    files: Vec<ImageFile>,
    next: usize,
    skipped: Vec<SkippedInput>,
}

impl FileSequence {
    /// A sequence of files in the order given, and what was left out before.
    #[must_use]
    pub fn new(
        camera: Camera,
        files: Vec<ImageFile>,
        range: SequenceRange,
        skipped: Vec<SkippedInput>,
    ) -> Self {
        let end = range.end.unwrap_or(files.len()).min(files.len());
        let files = files.into_iter().take(end).skip(range.start).step_by(range.stride.max(1)).collect();
        Self { camera, files, next: 0, skipped }
    }
}

impl ImageSource for FileSequence {
    fn camera(&self) -> &Camera {
        &self.camera
    }

    fn next_image(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        loop {
            let file = self.files.get(self.next)?;
            self.next += 1;
            let (width, height) = self.camera.size_px();
            let reason = match read_gray_image(&file.path) {
                Ok(image) if (image.width(), image.height()) == (width as usize, height as usize) => {
                    return Some(Ok(GrayFrame { at: file.at, image }));
                }
                Ok(image) => {
                    format!("expected {width} x {height} px, found {} x {}", image.width(), image.height())
                }
                Err(error) => error.to_string(),
            };
            let origin = file.path.display().to_string();
            self.skipped.push(SkippedInput { at: Some(file.at), origin, reason });
        }
    }

    fn num_images(&self) -> Option<usize> {
        Some(self.files.len())
    }

    fn skipped(&self) -> &[SkippedInput] {
        &self.skipped
    }
}
