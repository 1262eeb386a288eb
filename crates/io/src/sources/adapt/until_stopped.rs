//! A source that ends when the program is asked to stop.

use visloc_core::{ImageSource, Source, SourceError, SourceStatus, geom::Camera};

use crate::sources::Host;

/// As the source inside, until the stop sign is set. So whoever works through a source to its end writes all results so far.
pub struct UntilStopped<S> {
    inner: S,
    host: Host,
    /// A live source ends in no other way, so nothing is left undone.
    is_live: bool,
}

visloc_core::debug_shows!([S: std::fmt::Debug] UntilStopped<S> { inner, is_live });

impl<S> UntilStopped<S> {
    /// Around a source of which something is left undone when it is stopped.
    pub fn new(inner: S, host: &Host) -> Self {
        Self { inner, host: host.clone(), is_live: false }
    }

    /// Around a source that is live, or not: a live one is at its end when it is stopped.
    pub fn of_kind(inner: S, host: &Host, is_live: bool) -> Self {
        Self { inner, host: host.clone(), is_live }
    }

    fn is_stopped(&self) -> bool {
        let is_stopped = self.host.is_stopped();
        if is_stopped && !self.is_live {
            self.host.note_interruption();
        }
        is_stopped
    }
}

impl<T, S: Source<T>> Source<T> for UntilStopped<S> {
    fn next_item(&mut self) -> Option<Result<T, SourceError>> {
        if self.is_stopped() {
            return None;
        }
        // Ctrl-C reaches the program that decodes a video as well; that this breaks off is no fault of the video.
        match self.inner.next_item() {
            Some(Ok(item)) => {
                self.host.note_begin();
                Some(Ok(item))
            }
            ended => ended.filter(|_| !self.is_stopped()),
        }
    }

    fn status(&self) -> SourceStatus<'_> {
        self.inner.status()
    }
}

impl<S: ImageSource> ImageSource for UntilStopped<S> {
    fn camera(&self) -> &Camera {
        self.inner.camera()
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::{Picture, RgbImage, Timestamp};

    use super::*;

    struct Endless;

    impl Source<Picture> for Endless {
        fn next_item(&mut self) -> Option<Result<Picture, SourceError>> {
            Some(Ok(Picture { at: Timestamp::default(), image: RgbImage::new(1, 1), file: None }))
        }
    }

    #[test]
    fn a_stopped_source_has_ended_and_only_a_live_one_is_complete() {
        for is_live in [false, true] {
            let host = Host::silent();
            let mut source = UntilStopped::of_kind(Endless, &host, is_live);
            assert!(!host.has_begun());
            assert!(source.next_item().is_some() && host.has_begun() && !host.was_interrupted());
            host.stop();
            assert!(source.next_item().is_none());
            assert_eq!(host.was_interrupted(), !is_live);
        }
    }
}
