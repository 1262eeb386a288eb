//! Several cameras of one robot.

use visloc_core::{SkippedInput, Source, SourceError, SourceFrame, SourceStatus};

/// The frames of several cameras in the order of their stamps; of those with the same stamp, that of the first camera first.
pub struct ManyCameras {
    cameras: Vec<OneCamera>,
    /// Where input comes from that all cameras have in common: what was left out of it counts once.
    in_common: Vec<String>,
    skipped: Vec<SkippedInput>,
    error: Option<SourceError>,
}

visloc_core::debug_shows!([] ManyCameras { in_common, skipped, error });

struct OneCamera {
    frames: Box<dyn Source<SourceFrame>>,
    next: Option<SourceFrame>,
    has_ended: bool,
    /// How much of what it left out is known.
    num_skipped: usize,
}

impl ManyCameras {
    /// From one source for each camera. All see the same robot; `in_common` are the origins, for instance topics, of what they read all.
    pub fn new(sources: Vec<Box<dyn Source<SourceFrame>>>, in_common: Vec<String>) -> Self {
        let camera = |frames| OneCamera { frames, next: None, has_ended: false, num_skipped: 0 };
        Self {
            cameras: sources.into_iter().map(camera).collect(),
            in_common,
            skipped: Vec::new(),
            error: None,
        }
    }

    /// Reads on until it is known which frame of each camera comes next.
    fn read_on(&mut self) {
        for (index, camera) in self.cameras.iter_mut().enumerate() {
            if camera.next.is_some() || camera.has_ended {
                continue;
            }
            match camera.frames.next_item() {
                Some(Ok(mut next)) => {
                    next.frame.camera_index = index;
                    camera.next = Some(next);
                }
                Some(Err(error)) => {
                    self.error.get_or_insert(error);
                    camera.has_ended = true;
                }
                None => camera.has_ended = true,
            }
            let skipped = camera.frames.status().skipped;
            let is_new = |input: &&SkippedInput| index == 0 || !self.in_common.contains(&input.origin);
            self.skipped.extend(skipped.iter().skip(camera.num_skipped).filter(is_new).cloned());
            camera.num_skipped = skipped.len();
        }
    }
}

impl Source<SourceFrame> for ManyCameras {
    fn next_item(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        self.read_on();
        let waiting = self.cameras.iter_mut().filter(|camera| camera.next.is_some());
        let earliest = waiting.min_by_key(|camera| camera.next.as_ref().map(|next| next.frame.at));
        let next = earliest.and_then(|camera| camera.next.take());
        next.map(Ok).or_else(|| self.error.take().map(Err))
    }

    fn status(&self) -> SourceStatus<'_> {
        let num_items = self.cameras.iter().map(|camera| camera.frames.status().num_items).sum();
        SourceStatus { num_items, skipped: &self.skipped, ..SourceStatus::default() }
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::{
        Frame, RgbImage, Timestamp,
        geom::{Camera, Mount},
    };

    use super::*;

    /// Frames at these times, then maybe an error.
    struct Times(Vec<f64>, bool);

    impl Source<SourceFrame> for Times {
        fn next_item(&mut self) -> Option<Result<SourceFrame, SourceError>> {
            if self.0.is_empty() {
                let error = SourceError::Broken { origin: "bag".into(), reason: "cut off".into() };
                return std::mem::take(&mut self.1).then_some(Err(error));
            }
            let at = Timestamp::from_secs(self.0.remove(0));
            let (camera, mount) = (Camera::default(), Mount::default().robot_from_camera());
            Some(Ok(SourceFrame { frame: Frame::new(at, RgbImage::new(1, 1), camera, mount), truth: None }))
        }

        fn status(&self) -> SourceStatus<'_> {
            SourceStatus { num_items: Some(self.0.len()), ..SourceStatus::default() }
        }
    }

    #[test]
    fn frames_come_in_order_of_time_and_an_error_at_the_end() {
        let sources: Vec<Box<dyn Source<SourceFrame>>> =
            vec![Box::new(Times(vec![1.0, 2.0, 3.0], false)), Box::new(Times(vec![0.5, 1.0, 1.5], true))];
        let mut cameras = ManyCameras::new(sources, Vec::new());
        assert_eq!(cameras.status().num_items, Some(6));
        let mut seen = Vec::new();
        let error = loop {
            match cameras.next_item() {
                Some(Ok(next)) => {
                    seen.push((next.frame.at.secs_since(Timestamp::default()), next.frame.camera_index))
                }
                end => break end,
            }
        };
        assert_eq!(seen, [(0.5, 1), (1.0, 0), (1.0, 1), (1.5, 1), (2.0, 0), (3.0, 0)]);
        assert!(matches!(error, Some(Err(_))));
        assert!(cameras.next_item().is_none());
    }
}
