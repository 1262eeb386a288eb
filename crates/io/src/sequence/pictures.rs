//! The images of a sequence in color, with or without a calibration.

use visloc_core::{Picture, PictureSource, SkippedInput, SourceError};

use super::ImageFile;
use crate::image_codec::{decode, read_image_file};

/// Reads images one after another, PNG or JPEG, gray ones too. One that is missing or damaged is left out and noted.
#[derive(Debug, Clone)]
pub struct FilePictures {
    files: Vec<ImageFile>,
    next: usize,
    original: Option<Vec<u8>>,
    skipped: Vec<SkippedInput>,
}

impl FilePictures {
    /// The files in the order given, and what was left out before.
    #[must_use]
    pub fn new(files: Vec<ImageFile>, skipped: Vec<SkippedInput>) -> Self {
        Self { files, next: 0, original: None, skipped }
    }
}

impl PictureSource for FilePictures {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        loop {
            let file = self.files.get(self.next)?;
            self.next += 1;
            match read_image_file(&file.path).and_then(|bytes| Ok((decode(&bytes)?, bytes))) {
                Ok((image, bytes)) => {
                    self.original = Some(bytes);
                    return Some(Ok(Picture { at: file.at, image }));
                }
                Err(error) => {
                    let origin = file.path.display().to_string();
                    self.skipped.push(SkippedInput { at: Some(file.at), origin, reason: error.to_string() });
                }
            }
        }
    }

    fn original(&self) -> Option<&[u8]> {
        self.original.as_deref()
    }

    fn num_pictures(&self) -> Option<usize> {
        Some(self.files.len())
    }

    fn skipped(&self) -> &[SkippedInput] {
        &self.skipped
    }
}
