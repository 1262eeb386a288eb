//! A source that ends when the program is asked to stop.

use visloc_core::{
    FrameSource, GrayFrame, ImageSource, Picture, PictureSource, SkippedInput, SourceError, SourceFrame,
    Timestamp, geom::Camera,
};

use crate::sources::Host;

/// As the source inside, until the stop sign is set. So whoever works through a source to its end writes all results so far.
pub struct UntilStopped<S> {
    inner: S,
    host: Host,
    /// A live source ends in no other way, so nothing is left undone.
    is_live: bool,
}

impl<S> UntilStopped<S> {
    /// Around a source of which something is left undone when it is stopped.
    pub fn new(inner: S, host: &Host) -> Self {
        Self { inner, host: host.clone(), is_live: false }
    }

    /// Around a source that is live, or not: a live one is at its end when it is stopped.
    #[must_use]
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

    fn next_of<T>(
        &mut self,
        next: impl FnOnce(&mut S) -> Option<Result<T, SourceError>>,
    ) -> Option<Result<T, SourceError>> {
        if self.is_stopped() {
            return None;
        }
        // Ctrl-C reaches the program that decodes a video as well; that this breaks off is no fault of the video.
        match next(&mut self.inner) {
            Some(Ok(item)) => {
                self.host.note_begin();
                Some(Ok(item))
            }
            ended => ended.filter(|_| !self.is_stopped()),
        }
    }
}

impl FrameSource for UntilStopped<Box<dyn FrameSource>> {
    fn next_frame(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        self.next_of(|inner| inner.next_frame())
    }

    fn num_frames(&self) -> Option<usize> {
        self.inner.num_frames()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.inner.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.inner.num_dropped()
    }

    fn received_at(&self) -> Option<Timestamp> {
        self.inner.received_at()
    }
}

impl ImageSource for UntilStopped<Box<dyn ImageSource>> {
    fn camera(&self) -> &Camera {
        self.inner.camera()
    }

    fn next_image(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        self.next_of(|inner| inner.next_image())
    }

    fn num_images(&self) -> Option<usize> {
        self.inner.num_images()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.inner.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.inner.num_dropped()
    }
}

impl PictureSource for UntilStopped<Box<dyn PictureSource>> {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        self.next_of(|inner| inner.next_picture())
    }

    fn original(&self) -> Option<&[u8]> {
        self.inner.original()
    }

    fn num_pictures(&self) -> Option<usize> {
        self.inner.num_pictures()
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

    struct Endless;

    impl PictureSource for Endless {
        fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
            Some(Ok(Picture { at: Timestamp::default(), image: RgbImage::new(1, 1) }))
        }
    }

    #[test]
    fn a_stopped_source_has_ended_and_only_a_live_one_is_complete() {
        for is_live in [false, true] {
            let host = Host::silent();
            let mut source: UntilStopped<Box<dyn PictureSource>> =
                UntilStopped::of_kind(Box::new(Endless), &host, is_live);
            assert!(!host.has_begun());
            assert!(source.next_picture().is_some() && host.has_begun() && !host.was_interrupted());
            host.stop();
            assert!(source.next_picture().is_none());
            assert_eq!(host.was_interrupted(), !is_live);
        }
    }
}
