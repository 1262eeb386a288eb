//! Which images of a sequence are used.

use std::str::FromStr;

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
    /// Whether it ends before it begins, whatever the sequence.
    pub fn is_backward(&self) -> bool {
        match (self.start, self.end) {
            (Bound::Frame(start), Some(Bound::Frame(end))) => end < start,
            (Bound::Secs(start), Some(Bound::Secs(end))) => end < start,
            _ => false,
        }
    }

    /// The images in the range.
    pub fn select(&self, files: Vec<ImageFile>) -> Vec<ImageFile> {
        let Some(first) = files.first().map(|file| file.at) else { return files };
        let index = |bound: Bound| match bound {
            Bound::Frame(index) => index,
            Bound::Secs(secs) => files.partition_point(|file| file.at.secs_since(first) < secs),
        };
        let end = self.end.map_or(files.len(), index).min(files.len());
        let start = index(self.start);
        files
            .into_iter()
            .take(end)
            .skip(start)
            .step_by(self.stride.max(1))
            .take(self.most.unwrap_or(usize::MAX))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::Timestamp;

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
    fn senseless_bounds_are_refused() {
        for text in ["", "s", "-1", "-1s", "nans", "1.5", "five"] {
            let error = text.parse::<Bound>().unwrap_err();
            assert!(error.contains("expected a number of images"), "{error}");
        }
    }
}
