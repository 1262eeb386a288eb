//! For commands that make sense with one camera only.

use visloc_core::{Mapped, Source, SourceError, SourceFrame};

/// Refuses a robot with several cameras: the frames end with an error if a second camera takes one.
pub fn of_one_camera(inner: Box<dyn Source<SourceFrame>>, source: &str) -> Box<dyn Source<SourceFrame>> {
    let origin = source.to_owned();
    Box::new(Mapped::new(inner, move |next: SourceFrame| {
        if next.frame.camera_index == 0 {
            return Ok(next);
        }
        let reason = "expected images of one camera, found those of a second one: several are used by visloc localize on a drawn map";
        Err(SourceError::Broken { origin: origin.clone(), reason: reason.to_owned() })
    }))
}
