//! A part of a source.

use visloc_core::{Source, SourceError, SourceStatus};

use super::Shot;
use crate::sequence::{InRange, RangeJudge, SequenceRange};

/// The images in a range.
pub(super) struct Ranged<T> {
    inner: Box<dyn Source<T>>,
    judge: RangeJudge,
}

impl<T> Ranged<T> {
    pub(super) fn new(inner: Box<dyn Source<T>>, range: SequenceRange) -> Self {
        Self { inner, judge: RangeJudge::new(range) }
    }

    /// Why no image came, as the end of a sentence: what the source has beside what was asked for.
    pub(super) fn why_none(&self) -> String {
        if self.judge.range() == SequenceRange::default() {
            return String::new();
        }
        let secs = self.judge.span_secs().unwrap_or_default();
        let has = match (self.judge.num_seen(), self.inner.status().num_items) {
            _ if self.judge.has_ended() => ": it ends before it begins".into(),
            (0, None) => String::new(),
            (0, Some(num)) => format!(": the source has {num} images"),
            (num, _) => format!(": the source has {num} images, {secs:.1} s long"),
        };
        format!(" in the range that was asked for{has}")
    }
}

impl<T: Shot> Source<T> for Ranged<T> {
    fn next_item(&mut self) -> Option<Result<T, SourceError>> {
        let num_images = self.inner.status().num_items;
        // A live source is not waited for, and a long one not read to its end for nothing.
        while !self.judge.is_over(num_images) {
            let item = match self.inner.next_item()? {
                Ok(item) => item,
                Err(error) => return Some(Err(error)),
            };
            match self.judge.of_image(item.at()) {
                InRange::Taken => return Some(Ok(item)),
                InRange::Before | InRange::Between => {}
                InRange::Behind => return None,
            }
        }
        None
    }

    fn status(&self) -> SourceStatus<'_> {
        let status = self.inner.status();
        let num_items = status.num_items.filter(|_| self.judge.range() == SequenceRange::default());
        SourceStatus { num_items, ..status }
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::{Picture, RgbImage, Timestamp};

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
