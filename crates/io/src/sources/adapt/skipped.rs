//! What was left out, by a source and by what stands behind it.

use visloc_core::SkippedInput;

/// Most entries that are kept; bounds memory of live sources.
const MAX_SKIPPED: usize = 10_000;

/// Entries of an adapter and of its source, in the order in which they came.
#[derive(Debug, Default)]
pub(super) struct SkippedLog {
    all: Vec<SkippedInput>,
    num_seen: usize,
}

impl SkippedLog {
    /// Takes over what the source has noted since the last time.
    pub(super) fn follow(&mut self, of_source: &[SkippedInput]) {
        for skipped in of_source.iter().skip(self.num_seen) {
            if self.all.len() < MAX_SKIPPED {
                self.all.push(skipped.clone());
            }
        }
        self.num_seen = of_source.len();
    }

    pub(super) fn push(&mut self, skipped: SkippedInput) {
        if self.all.len() < MAX_SKIPPED {
            self.all.push(skipped);
        }
    }

    pub(super) fn all(&self) -> &[SkippedInput] {
        &self.all
    }
}
