//! Images that all have the same size.

use visloc_core::{SkippedInput, Source, SourceError, SourceStatus};

use super::Shot;
use crate::bag::MAX_SKIPPED;

/// After so many images in a row of another size, the source ends.
const MAX_WRONG_SIZE: usize = 10;

/// Leaves out images of another size; one whose images have got another size for good ends.
pub(super) struct SameSize<T> {
    inner: Box<dyn Source<T>>,
    origin: String,
    /// Width and height, pixels.
    size_px: (u32, u32),
    num_wrong: usize,
    /// What was left out here and by the source inside, in the order in which it came.
    skipped: Vec<SkippedInput>,
    /// How much of what the source inside left out is known.
    num_known: usize,
}

impl<T> SameSize<T> {
    pub(super) fn new(inner: Box<dyn Source<T>>, size_px: (u32, u32), origin: String) -> Self {
        Self { inner, origin, size_px, num_wrong: 0, skipped: Vec::new(), num_known: 0 }
    }

    fn note_skipped(&mut self) {
        let of_source = self.inner.status().skipped;
        let room = MAX_SKIPPED.saturating_sub(self.skipped.len());
        self.skipped.extend(of_source.iter().skip(self.num_known).take(room).cloned());
        self.num_known = of_source.len();
    }
}

impl<T: Shot> Source<T> for SameSize<T> {
    fn next_item(&mut self) -> Option<Result<T, SourceError>> {
        loop {
            let next = self.inner.next_item();
            self.note_skipped();
            let item = match next? {
                Ok(item) => item,
                Err(error) => return Some(Err(error)),
            };
            let ((width, height), found) = (self.size_px, item.size_px());
            if found == self.size_px {
                self.num_wrong = 0;
                return Some(Ok(item));
            }
            self.num_wrong += 1;
            let reason = format!(
                "expected {width} x {height} px as in the first image, found {} x {}",
                found.0, found.1
            );
            let origin = self.origin.clone();
            if self.num_wrong >= MAX_WRONG_SIZE {
                let reason = format!("{reason}, {MAX_WRONG_SIZE} times in a row");
                return Some(Err(SourceError::Broken { origin, reason }));
            }
            if self.skipped.len() < MAX_SKIPPED {
                self.skipped.push(SkippedInput { at: Some(item.at()), origin, reason });
            }
        }
    }

    fn status(&self) -> SourceStatus<'_> {
        SourceStatus { skipped: &self.skipped, ..self.inner.status() }
    }
}
