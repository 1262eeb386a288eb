//! What takes the images of a session in: a system that makes its map, or one that finds the camera in the map of an earlier session.

use serde_json::Value;
use visloc_core::{
    CameraTrajectory, Clock, GrayFrame, Timestamp,
    geom::{Camera, CameraFrame, Rigid3, World},
};
use visloc_slam::{FrameOutcome, Schedule, Slam, SlamConfig, SlamFrame};
use visloc_vmap::{MapLocalizer, Session, VisualMap, packing};

use super::{
    in_map::MapViewer,
    moment::SlamMoment,
    taught::{Job, PROGRAM},
    viewer::SlamViewer,
};
use crate::StudioError;

/// A running system and what shows it.
pub(super) enum System {
    /// Makes its map.
    Mapping(Box<Slam>, SlamViewer),
    /// Finds the camera.
    InMap(Box<MapLocalizer>, MapViewer),
}

/// What a system is started for.
pub(super) struct Start<'a> {
    pub camera: &'a Camera,
    pub title: &'a str,
    pub truth: Option<CameraTrajectory>,
    pub job: &'a Job,
    pub config: &'a SlamConfig,
    pub seed: u64,
    pub clock: Clock,
    /// What the scene message has besides.
    pub fields: Value,
}

impl System {
    /// Starts a system.
    pub fn start(start: Start<'_>) -> Result<Self, StudioError> {
        let Start { camera, title, truth, job, config, seed, clock, fields } = start;
        let refused = |error: visloc_slam::ConfigError| StudioError::input("SLAM", error);
        let map = match job {
            Job::Find(map) => map,
            Job::Teach(known) => {
                let slam = match known {
                    Some(known) => Slam::resume(known.map.clone(), camera, config, seed, Schedule::default()),
                    None => Slam::new(camera, config, seed),
                };
                let mut slam = slam.map_err(refused)?;
                slam.set_clock(clock);
                slam.set_packing(packing());
                return Ok(Self::Mapping(Box::new(slam), SlamViewer::new(camera, title, truth, fields)));
            }
        };
        let mut localizer = MapLocalizer::in_map(map, camera, config, seed).map_err(refused)?;
        localizer.set_clock(clock);
        Ok(Self::InMap(Box::new(localizer), MapViewer::new(camera, title, map, truth, fields)))
    }

    /// Takes in a frame; what became of it if it makes its map.
    pub fn take(&mut self, frame: &GrayFrame) -> Result<Option<FrameOutcome>, StudioError> {
        let refused = |error| StudioError::input("image", error);
        match self {
            Self::Mapping(slam, viewer) => {
                let outcome = slam.add_frame(frame.at, frame.image.clone()).map_err(refused)?;
                viewer.follow(slam, &SlamFrame { at: frame.at, image: &frame.image, outcome: &outcome });
                Ok(Some(outcome))
            }
            Self::InMap(localizer, viewer) => {
                localizer.step(frame.clone()).map_err(refused)?;
                viewer.follow(localizer, frame);
                Ok(None)
            }
        }
    }

    /// What there is to see of the last frame, of which [`System::take`] has told the outcome; `None` before the first one.
    pub fn moment(
        &mut self,
        frame: &GrayFrame,
        outcome: Option<&FrameOutcome>,
        more: &Value,
    ) -> Result<Option<SlamMoment>, StudioError> {
        match (self, outcome) {
            (Self::Mapping(slam, viewer), Some(outcome)) => {
                let frame = SlamFrame { at: frame.at, image: &frame.image, outcome };
                viewer.moment(slam, &frame, more).map(Some)
            }
            (Self::Mapping(..), None) => Ok(None),
            (Self::InMap(localizer, viewer), _) => viewer.moment(localizer, frame, more),
        }
    }

    /// The map so far, which may have begun with a known one, and the system that makes it; in the frame of the truth if that is known. `None`
    /// if there is no map yet, or if a map of an earlier session stays as it is.
    pub fn taught(&self, known: Option<&VisualMap>, seed: u64) -> Option<(VisualMap, &Slam)> {
        let Self::Mapping(slam, viewer) = self else { return None };
        slam.map().all_keyframes().next()?;
        let session = Session {
            source: viewer.title().to_owned(),
            program: PROGRAM.to_owned(),
            num_images: viewer.num_frames(),
            seed,
        };
        let mut map = known.cloned().unwrap_or_default().after(slam, session);
        if let (Some(largest), Some(truth)) = (map.largest(), viewer.truth()) {
            // Where too little is known of the truth it has a frame and a unit of its own.
            let _ = map.align(largest, truth);
        }
        Some((map, slam))
    }

    /// What shows the system.
    pub fn viewer(&mut self) -> &mut SlamViewer {
        match self {
            Self::Mapping(_, viewer) => viewer,
            Self::InMap(_, viewer) => viewer.viewer(),
        }
    }

    /// Where the camera was, if that is known.
    pub fn world_from_camera(&self, at: Timestamp) -> Option<&Rigid3<World, CameraFrame>> {
        match self {
            Self::Mapping(_, viewer) => viewer.world_from_camera(at),
            Self::InMap(_, viewer) => viewer.world_from_camera(at),
        }
    }

    /// Another truth from now on, of a camera that somebody carries elsewhere.
    pub fn set_truth(&mut self, truth: CameraTrajectory) {
        match self {
            Self::Mapping(_, viewer) => viewer.set_truth(truth),
            Self::InMap(_, viewer) => viewer.set_truth(truth),
        }
    }
}
