//! The images of a sequence in color, with or without a calibration.

use visloc_core::{Picture, SkippedInput, Source, SourceError, SourceStatus};

use super::ImageFile;
use crate::image_codec::{decode, read_image_file};

/// Reads images one after another, PNG or JPEG, gray ones too. One that is missing or damaged is left out and noted, and one of another
/// size if there is only one size.
#[derive(Debug, Clone)]
pub struct FilePictures {
    files: Vec<ImageFile>,
    /// Width and height, pixels.
    size_px: Option<(u32, u32)>,
    next: usize,
    skipped: Vec<SkippedInput>,
}

impl FilePictures {
    /// The files in the order given, and what was left out before.
    pub fn new(files: Vec<ImageFile>, skipped: Vec<SkippedInput>) -> Self {
        Self { files, size_px: None, next: 0, skipped }
    }

    /// Only those of a size, width and height in pixels.
    #[must_use]
    pub fn of_size(self, size_px: (u32, u32)) -> Self {
        Self { size_px: Some(size_px), ..self }
    }
}

impl Source<Picture> for FilePictures {
    fn next_item(&mut self) -> Option<Result<Picture, SourceError>> {
        loop {
            let file = self.files.get(self.next)?;
            self.next += 1;
            let read = read_image_file(&file.path).and_then(|bytes| Ok((decode(&bytes)?, bytes)));
            let reason = match (read, self.size_px) {
                (Ok((image, _)), Some((width, height)))
                    if (image.width(), image.height()) != (width, height) =>
                {
                    format!("expected {width} x {height} px, found {} x {}", image.width(), image.height())
                }
                (Ok((image, bytes)), _) => {
                    return Some(Ok(Picture { at: file.at, image, file: Some(bytes) }));
                }
                (Err(error), _) => error.to_string(),
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
