//! For commands that make sense with one camera only.

use visloc_core::{FrameSource, SkippedInput, SourceError, SourceFrame, Timestamp};

/// Frames that end with an error if a second camera takes one.
struct OneCamera {
    inner: Box<dyn FrameSource>,
    source: String,
}

/// Refuses a robot with several cameras.
pub fn of_one_camera(inner: Box<dyn FrameSource>, source: &str) -> Box<dyn FrameSource> {
    Box::new(OneCamera { inner, source: source.to_owned() })
}

impl FrameSource for OneCamera {
    fn next_frame(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        let next = self.inner.next_frame()?;
        let is_second = next.as_ref().is_ok_and(|next| next.frame.camera_index > 0);
        let reason = "expected images of one camera, found those of a second one: several are used by visloc localize on a drawn map";
        Some(if is_second {
            Err(SourceError::Broken { origin: self.source.clone(), reason: reason.to_owned() })
        } else {
            next
        })
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
