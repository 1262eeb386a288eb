//! Poses of the images before a map was started.

use std::sync::Arc;

use visloc_core::{
    Clock, Rng, Timestamp,
    geom::{Camera, CameraFrame, Rigid3},
};

use crate::{
    config::SlamConfig,
    image::Pyramid,
    map::{KeyframeId, Map},
    recognize::frame_of,
    timing::StageTimer,
    track::{FrameWork, Incoming, Quality, Tracker},
};

/// Images that are kept while there is no map, for their poses to be found later. They take about 1.4 bytes a pixel each.
pub(crate) const MOST_WAITING: usize = 45;

/// Follows the camera backwards from the second keyframe, through the images that were not tracked when they came.
#[derive(Debug)]
pub(crate) struct Backfill {
    camera: Camera,
    config: SlamConfig,
    /// Oldest first: number in the sequence, time and image.
    waiting: Vec<(usize, Timestamp, Arc<Pyramid>)>,
    first: KeyframeId,
    second: KeyframeId,
    tracker: Option<Tracker>,
}

/// Pose of a frame relative to a keyframe.
type Place = (KeyframeId, Rigid3<CameraFrame, CameraFrame>);

impl Backfill {
    /// Without any images.
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        Self {
            camera: *camera,
            config: config.clone(),
            waiting: Vec::new(),
            first: KeyframeId::default(),
            second: KeyframeId::default(),
            tracker: None,
        }
    }

    /// Takes over a camera that is known better.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.camera = *camera;
        if let Some(tracker) = &mut self.tracker {
            tracker.set_camera(camera);
        }
    }

    /// Keeps an image for which there is no map yet.
    pub fn keep(&mut self, incoming: &Incoming<'_>) {
        if self.waiting.len() >= MOST_WAITING {
            self.waiting.remove(0);
        }
        self.waiting.push((incoming.number, incoming.at, Arc::clone(incoming.pyramid)));
    }

    /// A map was started with two keyframes.
    pub fn start(&mut self, first: KeyframeId, second: KeyframeId) {
        (self.first, self.second) = (first, second);
        self.tracker = None;
    }

    /// The next frame backwards and where it was. `None` if there is none, or it cannot be followed any farther.
    pub fn next(&mut self, map: &Map, rng: &mut Rng) -> Option<(usize, Place)> {
        let (number, at, pyramid) = self.waiting.pop()?;
        let placed = self.follow(map, &Incoming { number, at, pyramid: &pyramid, odometry: None }, rng);
        if placed.is_none() {
            self.waiting.clear();
            self.tracker = None;
        }
        placed.map(|place| (number, (self.first, place)))
    }

    fn follow(
        &mut self,
        map: &Map,
        incoming: &Incoming<'_>,
        rng: &mut Rng,
    ) -> Option<Rigid3<CameraFrame, CameraFrame>> {
        if self.tracker.is_none() {
            let mut tracker = Tracker::new(&self.camera, &self.config.tracking, &self.config.features);
            tracker.restart_from(frame_of(map, self.second)?);
            self.tracker = Some(tracker);
        }
        let tracker = self.tracker.as_mut()?;
        let mut timer = StageTimer::start(Clock::still());
        let report = tracker.track(map, incoming, &mut FrameWork { rng, timer: &mut timer })?;
        if report.quality == Quality::Bad {
            return None;
        }
        let place = report.frame.camera_from_world * map.pose_of(self.first).inverse();
        tracker.accept(report.frame);
        Some(place)
    }
}
