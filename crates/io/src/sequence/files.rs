//! A sequence whose images are files.

use std::path::PathBuf;

use visloc_core::{
    GrayFrame, ImageSource, SkippedInput, Source, SourceError, SourceStatus, Timestamp, geom::Camera,
};

use super::SequenceRange;
use crate::image_codec::{read_gray_image, resize_gray};

/// An image that is still on the disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFile {
    /// When it was taken.
    pub at: Timestamp,
    /// Where it is.
    pub path: PathBuf,
}

/// Reads images one after another, gray or color, PNG or JPEG. One that is missing, damaged or of another size is left out and
/// noted.
#[derive(Debug)]
pub struct FileSequence {
    camera: Camera,
    /// Size of the images in the files, pixels.
    file_size_px: (u32, u32),
    files: Vec<ImageFile>,
    next: usize,
    skipped: Vec<SkippedInput>,
}

impl FileSequence {
    /// A sequence of files in the order given, and what was left out before. The camera is that of the files.
    pub fn new(
        camera: Camera,
        files: Vec<ImageFile>,
        range: SequenceRange,
        skipped: Vec<SkippedInput>,
    ) -> Self {
        let files = range.select(files);
        Self { camera, file_size_px: camera.size_px(), files, next: 0, skipped }
    }

    /// Shrinks or enlarges every image to the size of another camera, which becomes that of the sequence.
    #[must_use]
    pub fn resized(mut self, camera: Camera) -> Self {
        self.camera = camera;
        self
    }

    /// The images that will be read.
    pub fn files(&self) -> &[ImageFile] {
        &self.files
    }
}

impl ImageSource for FileSequence {
    fn camera(&self) -> &Camera {
        &self.camera
    }
}

impl Source<GrayFrame> for FileSequence {
    fn next_item(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        loop {
            let file = self.files.get(self.next)?;
            self.next += 1;
            let (width, height) = self.file_size_px;
            let reason = match read_gray_image(&file.path) {
                Ok(image) if (image.width(), image.height()) == (width as usize, height as usize) => {
                    let image = resize_gray(image, self.camera.size_px());
                    return Some(Ok(GrayFrame::new(file.at, image)));
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

    fn status(&self) -> SourceStatus<'_> {
        let num_items = Some(self.files.len());
        SourceStatus { num_items, skipped: &self.skipped, ..SourceStatus::default() }
    }
}
