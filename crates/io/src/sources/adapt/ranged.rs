//! A part of a source.

use visloc_core::{Source, SourceError, SourceStatus, Timestamp};

use super::Shot;
use crate::sequence::{Bound, SequenceRange};

/// The images in a range.
pub(super) struct Ranged<T> {
    inner: Box<dyn Source<T>>,
    range: SequenceRange,
    first_at: Option<Timestamp>,
    last_at: Option<Timestamp>,
    /// Images seen so far, and of them since the start of the range.
    num_seen: usize,
    num_inside: usize,
    num_taken: usize,
    /// Whether the range ended before the source.
    has_ended: bool,
}

/// What becomes of an image.
enum Verdict {
    Take,
    Leave,
    End,
}

impl<T> Ranged<T> {
    pub(super) fn new(inner: Box<dyn Source<T>>, range: SequenceRange) -> Self {
        Self {
            inner,
            range,
            first_at: None,
            last_at: None,
            num_seen: 0,
            num_inside: 0,
            num_taken: 0,
            has_ended: false,
        }
    }

    /// Whether no further image can be in the range, so that a live source is not waited for, and a long one is not read to its
    /// end for nothing.
    fn is_over(&self, num_images: Option<usize>) -> bool {
        let is_behind = |start: usize| num_images.is_some_and(|number| start >= number);
        self.range.most.is_some_and(|most| self.num_taken >= most)
            || matches!(self.range.end, Some(Bound::Frame(end)) if self.num_seen >= end)
            || matches!(self.range.start, Bound::Frame(start) if is_behind(start))
    }

    fn judge(&mut self, at: Timestamp) -> Verdict {
        let number = self.num_seen;
        self.num_seen += 1;
        let first_at = *self.first_at.get_or_insert(at);
        self.last_at = Some(at);
        let is_before = |bound: Bound| match bound {
            Bound::Frame(frame) => number < frame,
            Bound::Secs(secs) => at.secs_since(first_at) < secs,
        };
        if self.range.end.is_some_and(|end| !is_before(end)) {
            self.has_ended = true;
            return Verdict::End;
        }
        if is_before(self.range.start) {
            return Verdict::Leave;
        }
        self.num_inside += 1;
        let is_wanted = (self.num_inside - 1).is_multiple_of(self.range.stride.max(1));
        self.num_taken += usize::from(is_wanted);
        if is_wanted { Verdict::Take } else { Verdict::Leave }
    }

    /// Why no image came, as the end of a sentence: what the source has beside what was asked for.
    pub(super) fn why_none(&self) -> String {
        if self.range == SequenceRange::default() {
            return String::new();
        }
        let secs = self.first_at.zip(self.last_at).map_or(0.0, |(first, last)| last.secs_since(first));
        let has = match (self.num_seen, self.inner.status().num_items) {
            (0, None) => String::new(),
            (0, Some(num)) => format!(": the source has {num} images"),
            _ if self.has_ended => ": it ends before it begins".into(),
            (num, _) => format!(": the source has {num} images, {secs:.1} s long"),
        };
        format!(" in the range that was asked for{has}")
    }
}

impl<T: Shot> Source<T> for Ranged<T> {
    fn next_item(&mut self) -> Option<Result<T, SourceError>> {
        let num_images = self.inner.status().num_items;
        while !self.is_over(num_images) {
            let item = match self.inner.next_item()? {
                Ok(item) => item,
                Err(error) => return Some(Err(error)),
            };
            match self.judge(item.at()) {
                Verdict::Take => return Some(Ok(item)),
                Verdict::Leave => {}
                Verdict::End => return None,
            }
        }
        None
    }

    fn status(&self) -> SourceStatus<'_> {
        let status = self.inner.status();
        let num_items = status.num_items.filter(|_| self.range == SequenceRange::default());
        SourceStatus { num_items, ..status }
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::{Picture, RgbImage};

    use super::*;

    struct Numbers(u32);

    impl Source<Picture> for Numbers {
        fn next_item(&mut self) -> Option<Result<Picture, SourceError>> {
            self.0 += 1;
            let at = Timestamp::from_secs(10.0 + 0.5 * f64::from(self.0 - 1));
            (self.0 <= 10).then(|| Ok(Picture { at, image: RgbImage::new(self.0, 1), file: None }))
        }
    }

    #[test]
    fn the_same_ranges_as_for_files() {
        let numbers = |start: &str, end: Option<&str>, stride, most| {
            let end = end.map(|end| end.parse().unwrap());
            let range = SequenceRange { start: start.parse().unwrap(), end, stride, most };
            let mut ranged = Ranged::new(Box::new(Numbers(0)), range);
            let next = || Some((ranged.next_item()?.unwrap().image.width() - 1).to_string());
            std::iter::from_fn(next).collect::<String>()
        };
        assert_eq!(numbers("0", None, 1, None), "0123456789");
        assert_eq!(numbers("2", Some("7"), 2, Some(2)), "24");
        assert_eq!(numbers("1s", Some("2.5s"), 1, Some(9)), "234");
        assert_eq!(numbers("20", Some("3"), 1, None), "");
    }
}
