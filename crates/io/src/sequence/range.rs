//! Which images of a sequence are used.

use std::str::FromStr;

use visloc_core::Timestamp;

use super::ImageFile;

/// A place in a sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// So many images from the first.
    Frame(usize),
    /// So many seconds after the first image.
    Secs(f64),
}

impl FromStr for Bound {
    type Err = String;

    /// `120` is a number of images, `12.5s` a time in seconds.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected a number of images (120) or seconds (4.5s), found '{text}'");
        if let Some(secs) = text.strip_suffix('s') {
            let secs: f64 = secs.trim().parse().map_err(|_| expected())?;
            return if secs.is_finite() && secs >= 0.0 { Ok(Self::Secs(secs)) } else { Err(expected()) };
        }
        text.parse().map(Self::Frame).map_err(|_| expected())
    }
}

visloc_core::with_defaults! {
    /// Which images of a sequence are used.
    /// By default all images.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SequenceRange {
        /// The first image.
        pub start: Bound = Bound::Frame(0),
        /// One past the last image; `None` for all.
        pub end: Option<Bound> = None,
        /// One of so many images is used; 0 counts as 1.
        pub stride: usize = 1,
        /// Most images that are used; `None` for all.
        pub most: Option<usize> = None,
    }
}

impl SequenceRange {
    /// Whether it ends where it begins, or before, whatever the sequence.
    pub fn is_empty(&self) -> bool {
        match (self.start, self.end) {
            (Bound::Frame(start), Some(Bound::Frame(end))) => end <= start,
            (Bound::Secs(start), Some(Bound::Secs(end))) => end <= start,
            _ => false,
        }
    }

    /// The images in the range.
    pub fn select(&self, files: Vec<ImageFile>) -> Vec<ImageFile> {
        let mut judge = RangeJudge::new(*self);
        let verdicts = files.into_iter().map(|file| (judge.of_image(file.at), file));
        let inside = verdicts.take_while(|(verdict, _)| *verdict != InRange::Behind);
        inside.filter(|(verdict, _)| *verdict == InRange::Taken).map(|(_, file)| file).collect()
    }
}

/// Where something lies, judged by a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InRange {
    /// Before its start.
    Before,
    /// In it.
    Taken,
    /// In it, but one that the stride leaves out.
    Between,
    /// Behind its end, or all are taken: nothing that follows is in it.
    Behind,
}

/// Judges what comes, one after the other, by a range.
#[derive(Debug, Clone)]
pub struct RangeJudge {
    range: SequenceRange,
    first_at: Option<Timestamp>,
    last_at: Option<Timestamp>,
    has_begun: bool,
    has_ended: bool,
    /// Images until now, without one behind the end; of them since the start of the range; of these those that were taken.
    num_seen: usize,
    num_inside: usize,
    num_taken: usize,
}

impl RangeJudge {
    /// Of nothing that has come yet.
    pub fn new(range: SequenceRange) -> Self {
        let has_begun = matches!(range.start, Bound::Frame(0)) || range.start == Bound::Secs(0.0);
        let (first_at, last_at, has_ended) = (None, None, false);
        Self { range, first_at, last_at, has_begun, has_ended, num_seen: 0, num_inside: 0, num_taken: 0 }
    }

    /// Judges the next image.
    pub fn of_image(&mut self, at: Timestamp) -> InRange {
        self.first_at.get_or_insert(at);
        self.last_at = Some(at);
        let is_enough = self.range.most.is_some_and(|most| self.num_taken >= most);
        self.has_ended |= self.range.end.is_some_and(|end| self.is_reached(end, at, true));
        if is_enough || self.has_ended {
            return InRange::Behind;
        }
        self.has_begun = self.has_begun || self.is_reached(self.range.start, at, true);
        self.num_seen += 1;
        if !self.has_begun {
            return InRange::Before;
        }
        self.num_inside += 1;
        let is_taken = (self.num_inside - 1).is_multiple_of(self.range.stride.max(1));
        self.num_taken += usize::from(is_taken);
        if is_taken { InRange::Taken } else { InRange::Between }
    }

    /// Judges what came beside the images.
    pub fn of_other(&mut self, at: Timestamp) -> InRange {
        self.has_ended |= self.range.end.is_some_and(|end| self.is_reached(end, at, false));
        if self.has_ended {
            return InRange::Behind;
        }
        self.has_begun = self.has_begun || self.is_reached(self.range.start, at, false);
        if self.has_begun { InRange::Taken } else { InRange::Before }
    }

    fn is_reached(&self, bound: Bound, at: Timestamp, is_image: bool) -> bool {
        match bound {
            Bound::Frame(frame) => is_image && self.num_seen >= frame,
            Bound::Secs(secs) => self.first_at.is_some_and(|first_at| at.secs_since(first_at) >= secs),
        }
    }

    /// Whether no further image can be in the range, of a source with so many.
    pub fn is_over(&self, num_images: Option<usize>) -> bool {
        self.range.most.is_some_and(|most| self.num_taken >= most)
            || self.has_ended()
            || matches!(self.range.start, Bound::Frame(start) if num_images.is_some_and(|num| start >= num))
    }

    /// The range.
    pub fn range(&self) -> SequenceRange {
        self.range
    }

    /// Whether its start has come.
    pub fn has_begun(&self) -> bool {
        self.has_begun
    }

    /// Whether its end has come, so that nobody knows how much follows.
    pub fn has_ended(&self) -> bool {
        self.has_ended || matches!(self.range.end, Some(Bound::Frame(end)) if self.num_seen >= end)
    }

    /// Images that were judged, without those behind the end.
    pub fn num_seen(&self) -> usize {
        self.num_seen
    }

    /// From the first image to the last one that came, seconds; `None` before the first.
    pub fn span_secs(&self) -> Option<f64> {
        Some(self.last_at?.secs_since(self.first_at?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_seconds_and_strides() {
        let files: Vec<ImageFile> = (0..10)
            .map(|i| ImageFile {
                at: Timestamp::from_secs(100.0 + 0.5 * f64::from(i)),
                path: format!("{i}").into(),
            })
            .collect();
        let names = |start: &str, end: Option<&str>, stride, most| {
            let end = end.map(|end| end.parse().unwrap());
            let range = SequenceRange { start: start.parse().unwrap(), end, stride, most };
            let names = range.select(files.clone()).into_iter().map(|file| file.path.display().to_string());
            names.collect::<String>()
        };
        assert_eq!(names("0", None, 1, None), "0123456789");
        assert_eq!(names("2", Some("7"), 2, Some(2)), "24");
        assert_eq!(names("1s", Some("2.5s"), 1, Some(9)), "234");
        assert_eq!(names("4.6s", None, 0, None), "");
        assert_eq!(names("20", Some("3"), 1, None), "");
    }

    #[test]
    fn what_comes_beside_images_is_judged_by_them() {
        let at = Timestamp::from_secs;
        let range = |start: &str, end: Option<&str>| SequenceRange {
            start: start.parse().unwrap(),
            end: end.map(|end| end.parse().unwrap()),
            ..SequenceRange::default()
        };
        let mut by_number = RangeJudge::new(range("1", Some("2")));
        assert_eq!(by_number.of_other(at(9.0)), InRange::Before);
        assert_eq!(by_number.of_image(at(10.0)), InRange::Before);
        assert_eq!(by_number.of_image(at(11.0)), InRange::Taken);
        assert_eq!(by_number.of_other(at(11.5)), InRange::Taken);
        assert!(by_number.is_over(None));
        assert_eq!(by_number.of_image(at(12.0)), InRange::Behind);
        assert_eq!((by_number.num_seen(), by_number.span_secs()), (2, Some(2.0)));
        let mut by_time = RangeJudge::new(range("0s", Some("0.5s")));
        assert_eq!(by_time.of_other(at(9.0)), InRange::Taken);
        assert_eq!(by_time.of_image(at(10.0)), InRange::Taken);
        assert_eq!(by_time.of_other(at(10.5)), InRange::Behind);
    }

    #[test]
    fn senseless_bounds_are_refused() {
        for text in ["", "s", "-1", "-1s", "nans", "1.5", "five"] {
            let error = text.parse::<Bound>().unwrap_err();
            assert!(error.contains("expected a number of images"), "{error}");
        }
    }
}
