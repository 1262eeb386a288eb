//! A part of a source.

use visloc_core::{GrayFrame, Picture, PictureSource, SkippedInput, SourceError, Timestamp};

use super::GrayStream;
use crate::sequence::{Bound, SequenceRange};

/// The pictures or gray images in a range.
pub(crate) struct Ranged<P> {
    inner: P,
    range: SequenceRange,
    first_at: Option<Timestamp>,
    last_at: Option<Timestamp>,
    /// Images seen so far, and of them since the start of the range.
    num_seen: usize,
    num_inside: usize,
}

/// What becomes of an image.
enum Verdict {
    Take,
    Leave,
    End,
}

impl<P> Ranged<P> {
    pub(crate) fn new(inner: P, range: SequenceRange) -> Self {
        Self { inner, range, first_at: None, last_at: None, num_seen: 0, num_inside: 0 }
    }

    /// Whether no further image can be in the range, so that a live source is not waited for, and a long one is not read to its
    /// end for nothing.
    fn is_over(&self, num_images: Option<usize>) -> bool {
        let is_behind = |start: usize| num_images.is_some_and(|number| start >= number);
        matches!(self.range.end, Some(Bound::Frame(end)) if self.num_seen >= end)
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
            return Verdict::End;
        }
        if is_before(self.range.start) {
            return Verdict::Leave;
        }
        self.num_inside += 1;
        let is_wanted = (self.num_inside - 1).is_multiple_of(self.range.stride.max(1));
        if is_wanted { Verdict::Take } else { Verdict::Leave }
    }

    /// The next item in the range.
    fn next_of<T>(
        &mut self,
        num_images: Option<usize>,
        mut next: impl FnMut(&mut P) -> Option<Result<T, SourceError>>,
        at: impl Fn(&T) -> Timestamp,
    ) -> Option<Result<T, SourceError>> {
        while !self.is_over(num_images) {
            let item = match next(&mut self.inner)? {
                Ok(item) => item,
                Err(error) => return Some(Err(error)),
            };
            match self.judge(at(&item)) {
                Verdict::Take => return Some(Ok(item)),
                Verdict::Leave => {}
                Verdict::End => return None,
            }
        }
        None
    }

    /// Why no image came, as the end of a sentence: what the source has beside what was asked for.
    pub(crate) fn why_none(&self) -> String {
        if self.range == SequenceRange::default() {
            return String::new();
        }
        let secs = self.first_at.zip(self.last_at).map_or(0.0, |(first, last)| last.secs_since(first));
        let has = match self.num_seen {
            0 => String::new(),
            num => format!(": the source has {num} images, {secs:.1} s long"),
        };
        format!(" in the range that was asked for{has}")
    }

    fn number(&self, number: Option<usize>) -> Option<usize> {
        number.filter(|_| self.range == SequenceRange::default())
    }
}

impl<P: PictureSource> PictureSource for Ranged<P> {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        self.next_of(self.inner.num_pictures(), P::next_picture, |picture| picture.at)
    }

    fn original(&self) -> Option<&[u8]> {
        self.inner.original()
    }

    fn num_pictures(&self) -> Option<usize> {
        self.number(self.inner.num_pictures())
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.inner.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.inner.num_dropped()
    }
}

impl GrayStream for Ranged<Box<dyn GrayStream>> {
    fn next_gray(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        self.next_of(self.inner.num_images(), |stream| stream.next_gray(), |frame| frame.at)
    }

    fn num_images(&self) -> Option<usize> {
        self.number(self.inner.num_images())
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.inner.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.inner.num_dropped()
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::RgbImage;

    use super::*;

    struct Numbers(u32);

    impl PictureSource for Numbers {
        fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
            self.0 += 1;
            let at = Timestamp::from_secs(10.0 + 0.5 * f64::from(self.0 - 1));
            (self.0 <= 10).then(|| Ok(Picture { at, image: RgbImage::new(self.0, 1) }))
        }
    }

    #[test]
    fn the_same_ranges_as_for_files() {
        let numbers = |start: &str, end: Option<&str>, stride| {
            let end = end.map(|end| end.parse().unwrap());
            let range = SequenceRange { start: start.parse().unwrap(), end, stride };
            let mut ranged = Ranged::new(Numbers(0), range);
            let next = || Some((ranged.next_picture()?.unwrap().image.width() - 1).to_string());
            std::iter::from_fn(next).collect::<String>()
        };
        assert_eq!(numbers("0", None, 1), "0123456789");
        assert_eq!(numbers("2", Some("7"), 2), "246");
        assert_eq!(numbers("1s", Some("2.5s"), 1), "234");
        assert_eq!(numbers("20", Some("3"), 1), "");
    }
}
