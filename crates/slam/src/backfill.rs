//! Poses of the images before a map was started, back to those that an earlier map knows.

use std::sync::Arc;

use nalgebra::Matrix6;
use visloc_core::{
    Clock, Rng, RngTree, Timestamp,
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

/// Images that are kept while there is no map, for their poses to be found later. They take about 1.4 bytes a pixel each. Of more those
/// are let go that differ least from the ones beside them: a camera that stands after a quick turn must not push that turn out.
pub(crate) const MOST_WAITING: usize = 45;
/// Tracked frames that are kept, for a loss: a quick turn takes half a second, and before it there is nothing that a map behind it knows.
const MOST_RECENT: usize = 15;

/// Frames over which the motion beside a gap is measured: single ones are some millimeters and tenths of a degree off.
pub(crate) const MOTION_FRAMES: usize = 3;

/// Follows the camera backwards from the second keyframe, through the images that were not tracked when they came.
#[derive(Debug)]
pub(crate) struct Backfill {
    camera: Camera,
    config: SlamConfig,
    /// For images that no start has seen, so that following them changes nothing for those that come.
    rng: Rng,
    /// The newest tracked frames and, while the camera is lost, those since: the next map may know them, too. Oldest first.
    recent: Vec<Waiting>,
    /// Images that a start has seen, oldest first.
    waiting: Vec<Waiting>,
    first: KeyframeId,
    second: KeyframeId,
    tracker: Option<Tracker>,
    /// The last frames that were followed, the oldest frame last.
    followed: Vec<Found>,
}

/// An image whose pose is looked for.
#[derive(Debug)]
struct Waiting {
    number: usize,
    at: Timestamp,
    pyramid: Arc<Pyramid>,
    /// Covariance of its pose in the map in which it was tracked; `None` if it was not.
    covariance: Option<Matrix6<f64>>,
    /// Whether a start has seen it.
    is_of_start: bool,
}

/// A frame that was followed.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    /// Its number.
    pub number: usize,
    /// When it was taken.
    pub at: Timestamp,
    /// The first keyframe of the map.
    pub keyframe: KeyframeId,
    /// Its pose relative to that keyframe.
    pub camera_from_keyframe: Rigid3<CameraFrame, CameraFrame>,
    /// The frame that was followed before it, the next one in time that was kept: its number, and its pose relative to that keyframe.
    pub next: Option<(usize, Rigid3<CameraFrame, CameraFrame>)>,
    /// Covariance of its own pose.
    pub covariance: Option<Matrix6<f64>>,
    /// Covariance of its pose in the map in which it was tracked before, if it was.
    pub covariance_before: Option<Matrix6<f64>>,
}

/// What came of the next frame backwards.
#[derive(Debug)]
pub(crate) enum BackfillStep {
    /// It was followed.
    Found(Box<Found>),
    /// It could not be followed, and none that was tracked in another map.
    Ended {
        /// The last frames that were followed, the oldest frame last.
        followed: Vec<Found>,
        /// The newest frame that was tracked in another map, and the covariance of its pose there.
        tracked: Box<(usize, Matrix6<f64>)>,
    },
}

impl Waiting {
    fn new(incoming: &Incoming<'_>, covariance: Option<Matrix6<f64>>, is_of_start: bool) -> Self {
        let Incoming { number, at, pyramid, .. } = *incoming;
        Self { number, at, pyramid: Arc::clone(pyramid), covariance, is_of_start }
    }
}

impl Backfill {
    /// Without any images.
    pub fn new(camera: &Camera, config: &SlamConfig, seed: u64) -> Self {
        Self {
            camera: *camera,
            config: config.clone(),
            rng: RngTree::new(seed).stream("backfill", 0),
            recent: Vec::new(),
            waiting: Vec::new(),
            first: KeyframeId::default(),
            second: KeyframeId::default(),
            tracker: None,
            followed: Vec::new(),
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
        self.waiting.push(Waiting::new(incoming, None, true));
        thin_out(&mut self.waiting, MOST_WAITING);
    }

    /// Keeps an image for a while that was tracked, with the covariance of its pose, or that could not be.
    pub fn remember(&mut self, incoming: &Incoming<'_>, covariance: Option<Matrix6<f64>>) {
        self.recent.push(Waiting::new(incoming, covariance, false));
        if covariance.is_some() {
            self.recent.drain(..self.recent.len().saturating_sub(MOST_RECENT));
        } else {
            // Once the camera is lost, the images before come with those that it takes until a start begins.
            thin_out(&mut self.recent, MOST_RECENT + MOST_WAITING);
        }
    }

    /// Lets go of the images before the camera was lost: it was found again, or all is begun anew.
    pub fn forget_recent(&mut self) {
        self.recent.clear();
    }

    /// A map was started with two keyframes.
    pub fn start(&mut self, first: KeyframeId, second: KeyframeId) {
        (self.first, self.second) = (first, second);
        self.tracker = None;
        self.followed.clear();
        if let Some(newest) = self.recent.last().map(|recent| recent.number) {
            self.waiting.retain(|waiting| waiting.number > newest);
            self.waiting.splice(..0, self.recent.drain(..));
        }
    }

    /// The next frame backwards and where it was. `None` if there is none, or it cannot be followed any farther.
    pub fn next(&mut self, map: &Map, rng: &mut Rng) -> Option<BackfillStep> {
        let waiting = self.waiting.pop()?;
        match self.follow(map, &waiting, rng) {
            Some(found) => {
                let num_old = (self.followed.len() + 1).saturating_sub(MOTION_FRAMES + 1);
                self.followed.drain(..num_old);
                self.followed.push(found.clone());
                Some(BackfillStep::Found(Box::new(found)))
            }
            None => {
                self.tracker = None;
                let followed = std::mem::take(&mut self.followed);
                let has_met = followed.last().is_some_and(|found| found.covariance_before.is_some());
                let others = std::mem::take(&mut self.waiting).into_iter().rev();
                let mut tracked =
                    std::iter::once(waiting).chain(others).filter_map(|w| Some((w.number, w.covariance?)));
                tracked
                    .next()
                    .filter(|_| !has_met)
                    .map(|tracked| BackfillStep::Ended { followed, tracked: Box::new(tracked) })
            }
        }
    }

    fn follow(&mut self, map: &Map, waiting: &Waiting, rng: &mut Rng) -> Option<Found> {
        let Waiting { number, at, pyramid, covariance, is_of_start } = waiting;
        if self.tracker.is_none() {
            let mut tracker = Tracker::new(&self.camera, &self.config.tracking, &self.config.features);
            tracker.restart_from(frame_of(map, self.second)?);
            self.tracker = Some(tracker);
        }
        let tracker = self.tracker.as_mut()?;
        let rng = if *is_of_start { rng } else { &mut self.rng };
        let mut timer = StageTimer::start(Clock::still());
        let incoming = Incoming::of_image(*number, *at, pyramid);
        let report = tracker.track(map, &incoming, &mut FrameWork { rng, timer: &mut timer })?;
        if report.quality == Quality::Bad {
            return None;
        }
        let found = Found {
            number: *number,
            at: *at,
            keyframe: self.first,
            camera_from_keyframe: report.frame.camera_from_world * map.pose_of(self.first).inverse(),
            next: self.followed.last().map(|next| (next.number, next.camera_from_keyframe)),
            covariance: report.covariance,
            covariance_before: *covariance,
        };
        tracker.accept(report.frame);
        Some(found)
    }
}

/// Lets go of the image without which the ones beside it differ least, if there are too many. The first and the last stay.
fn thin_out(images: &mut Vec<Waiting>, most: usize) {
    if images.len() <= most {
        return;
    }
    let least = (1..images.len().saturating_sub(1))
        .min_by_key(|&i| difference(&images[i - 1].pyramid, &images[i + 1].pyramid))
        .unwrap_or_default();
    images.remove(least);
}

/// How much two images differ, as the sum of what the pixels of the coarsest level do.
fn difference(a: &Pyramid, b: &Pyramid) -> u64 {
    let [a, b] = [a, b].map(|pyramid| pyramid.level(pyramid.num_levels() - 1).data());
    a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum()
}
