//! What is kept of every frame of a run that may have no end.

use std::ops::{Deref, DerefMut};

/// Entries kept of a live run whose records nobody has asked for: enough for its summary.
pub const MOST_OF_A_SUMMARY: usize = 4_096;
/// Entries kept of a live run that is to be drawn or written at its end: hours of frames, some 100 MB.
pub const MOST_ON_DEMAND: usize = 500_000;

/// One entry for each frame. Where memory is bounded, every other entry is dropped whenever it is full, so that what is
/// kept stands for the whole run evenly.
#[derive(Debug, Clone)]
pub struct Records<T> {
    kept: Vec<T>,
    most: Option<usize>,
    /// One of so many entries is kept.
    stride: usize,
    num_seen: usize,
    latest: Option<T>,
}

impl<T: Copy> Records<T> {
    /// Keeps at most so many entries; `None` keeps all.
    pub fn new(most: Option<usize>) -> Self {
        Self { kept: Vec::new(), most, stride: 1, num_seen: 0, latest: None }
    }

    /// How many entries a run keeps: all of a recording; of a live source a bounded number, more of them if they are to be
    /// drawn or written.
    pub fn most_of(is_live: bool, is_asked_for: bool) -> Option<usize> {
        is_live.then_some(if is_asked_for { MOST_ON_DEMAND } else { MOST_OF_A_SUMMARY })
    }

    /// Adds the entry of the next frame.
    pub fn push(&mut self, entry: T) {
        if self.num_seen.is_multiple_of(self.stride) {
            self.kept.push(entry);
        }
        self.num_seen += 1;
        self.latest = Some(entry);
        if self.most.is_some_and(|most| self.kept.len() >= most.max(2)) {
            let mut index = 0;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
        }
    }

    /// The entry of the last frame, whether it is kept or not.
    pub fn latest(&self) -> Option<&T> {
        self.latest.as_ref()
    }

    /// How many entries are kept at most, if there is a bound.
    pub fn most(&self) -> Option<usize> {
        self.most
    }

    /// How many frames there were.
    pub fn num_seen(&self) -> usize {
        self.num_seen
    }
}

impl<T> Deref for Records<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.kept
    }
}

impl<T> DerefMut for Records<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_spread_over_the_whole_run() {
        let mut records = Records::new(Some(100));
        (0..100_000_usize).for_each(|number| records.push(number));
        assert_eq!(records.num_seen(), 100_000);
        assert_eq!(records.latest(), Some(&99_999));
        assert!((50..100).contains(&records.len()), "{}", records.len());
        let steps: Vec<usize> = records.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(records[0] == 0 && steps.iter().all(|step| *step == steps[0]), "{steps:?}");
        assert!(records[records.len() - 1] + steps[0] >= 100_000);
    }

    #[test]
    fn recordings_are_kept_whole() {
        let mut records = Records::new(None);
        (0..10_000_usize).for_each(|number| records.push(number));
        assert_eq!(records.len(), 10_000);
    }
}
