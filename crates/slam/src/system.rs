//! The whole system, one frame at a time.

use std::sync::Arc;

use thiserror::Error;
use visloc_base::{GrayImage, Rng, RngTree, Timestamp};
use visloc_geom::{Camera, CameraFrame, Rigid3, World};

use crate::{
    config::SlamConfig,
    image::Pyramid,
    lie::CameraFromWorld,
    map::{KeyframeId, Map},
    mapping::{Mapper, MappingReport},
    relocate::Relocator,
    start::{Initializer, StartStep, StartWait, StartedMap},
    track::{Incoming, Quality, TrackReport, Tracker},
};

/// A source of time for measurements; never used for a result.
#[derive(Debug, Clone, Copy)]
pub struct Clock(fn() -> f64);

impl Clock {
    /// A clock that reads seconds.
    #[must_use]
    pub fn new(secs: fn() -> f64) -> Self {
        Self(secs)
    }

    /// A clock that stands still.
    #[must_use]
    pub fn none() -> Self {
        Self(|| 0.0)
    }

    /// Seconds since some start.
    #[must_use]
    pub fn secs(self) -> f64 {
        (self.0)()
    }
}

/// Time spent on the stages of one frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StageTimes {
    stages: Vec<(&'static str, f64)>,
}

impl StageTimes {
    /// Adds seconds to a stage.
    pub fn add(&mut self, stage: &'static str, secs: f64) {
        match self.stages.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, sum)) => *sum += secs,
            None => self.stages.push((stage, secs)),
        }
    }

    /// Names and seconds, in order of first use.
    #[must_use]
    pub fn stages(&self) -> &[(&'static str, f64)] {
        &self.stages
    }

    /// Sum over all stages, seconds.
    #[must_use]
    pub fn total_secs(&self) -> f64 {
        self.stages.iter().map(|(_, secs)| secs).sum()
    }
}

/// A frame that cannot be used. Nothing else changes: the next frame is welcome.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The image has another size than the camera.
    #[error("expected an image of {expected:?} px, found {found:?}")]
    Size {
        /// Width and height of the camera.
        expected: (usize, usize),
        /// Width and height of the image.
        found: (usize, usize),
    },
    /// The frame is not later than the one before.
    #[error("expected a time after {last}, found {found}")]
    Time {
        /// Time of the frame before.
        last: Timestamp,
        /// Time of this frame.
        found: Timestamp,
    },
}

/// What the system knows about where the camera is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrackingState {
    /// There is no map yet, and why.
    Starting(StartWait),
    /// The camera is tracked.
    Tracking(Quality),
    /// The camera is lost in its map.
    Lost,
}

/// What became of a frame.
#[derive(Debug, Clone)]
pub struct FrameOutcome {
    /// What the system knows now.
    pub state: TrackingState,
    /// Pose as known at this moment; `None` unless the frame is tracked.
    pub camera_from_world: Option<CameraFromWorld>,
    /// Places searched and landmarks found.
    pub matches: (usize, usize),
    /// What the mapper did.
    pub mapping: MappingReport,
    /// Whether a lost camera was found again in this frame.
    pub is_relocalized: bool,
    /// Time of tracking by stage.
    pub tracking: StageTimes,
    /// Time of mapping by stage.
    pub mapping_times: StageTimes,
    /// Pixels of the landmarks found, and whether each has converged; for pictures.
    pub features: Vec<(nalgebra::Point2<f64>, bool)>,
}

/// A frame's place in the trajectory: relative to a keyframe, so that it moves when the map is corrected.
#[derive(Debug, Clone, Copy)]
pub struct FramePose {
    /// When the frame was taken.
    pub at: Timestamp,
    /// The keyframe it hangs on and its pose relative to it; `None` for a frame without a pose.
    pub place: Option<(KeyframeId, Rigid3<CameraFrame, CameraFrame>)>,
}

/// A pose of the final trajectory.
#[derive(Debug, Clone, Copy)]
pub struct TrajectoryPose {
    /// When.
    pub at: Timestamp,
    /// Where the camera was, map units.
    pub world_from_camera: Rigid3<World, CameraFrame>,
}

/// Monocular SLAM, strictly in sequence: the same frames give the same bits.
#[derive(Debug)]
pub struct Slam {
    camera: Camera,
    config: SlamConfig,
    rng: Rng,
    clock: Clock,
    map: Map,
    initializer: Initializer,
    tracker: Tracker,
    relocator: Relocator,
    mapper: Option<Mapper>,
    frames: Vec<FramePose>,
    num_bad: usize,
    is_lost: bool,
    started_at: usize,
}

/// Frames within which a loss means that the start was wrong.
const PROBATION_FRAMES: usize = 30;

impl Slam {
    /// A system for one camera. The seed fixes every random choice.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn new(camera: &Camera, config: &SlamConfig, seed: u64) -> Result<Self, crate::ConfigError> {
        config.check()?;
        Ok(Self {
            camera: *camera,
            config: config.clone(),
            rng: RngTree::new(seed).stream("slam", 0),
            clock: Clock::none(),
            map: Map::new(),
            initializer: Initializer::new(camera, config),
            tracker: Tracker::new(camera, &config.tracking, &config.features),
            relocator: Relocator::new(camera, config),
            mapper: None,
            frames: Vec::new(),
            num_bad: 0,
            is_lost: false,
            started_at: 0,
        })
    }

    /// Measures times with a clock.
    pub fn set_clock(&mut self, clock: Clock) {
        self.clock = clock;
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> &Map {
        &self.map
    }

    /// All frames so far.
    #[must_use]
    pub fn frames(&self) -> &[FramePose] {
        &self.frames
    }

    /// Poses of all frames that have one, with all corrections of the map so far.
    #[must_use]
    pub fn trajectory(&self) -> Vec<TrajectoryPose> {
        let pose = |frame: &FramePose| {
            let (keyframe, camera_from_keyframe) = frame.place?;
            let camera_from_world = camera_from_keyframe * self.map.pose_of(keyframe);
            Some(TrajectoryPose { at: frame.at, world_from_camera: camera_from_world.inverse() })
        };
        self.frames.iter().filter_map(pose).collect()
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// If the frame cannot be used; it is left out.
    pub fn add_frame(&mut self, at: Timestamp, image: GrayImage) -> Result<FrameOutcome, FrameError> {
        self.check_frame(at, &image)?;
        let mut tracking = StageTimes::default();
        let start = self.clock.secs();
        let pyramid = Arc::new(Pyramid::new(image, self.config.features.pyramid_levels));
        tracking.add("start frame", self.clock.secs() - start);
        self.frames.push(FramePose { at, place: None });
        let mut outcome = FrameOutcome {
            state: TrackingState::Lost,
            camera_from_world: None,
            matches: (0, 0),
            mapping: MappingReport::default(),
            is_relocalized: false,
            tracking,
            mapping_times: StageTimes::default(),
            features: Vec::new(),
        };
        if self.mapper.is_none() {
            self.start(at, &pyramid, &mut outcome);
        } else if self.is_lost {
            self.relocalize(at, &pyramid, &mut outcome);
        } else {
            self.track(at, &pyramid, &mut outcome);
        }
        Ok(outcome)
    }

    fn check_frame(&self, at: Timestamp, image: &GrayImage) -> Result<(), FrameError> {
        let (width, height) = self.camera.size_px();
        let (expected, found) = ((width as usize, height as usize), (image.width(), image.height()));
        if expected != found {
            return Err(FrameError::Size { expected, found });
        }
        match self.frames.last() {
            Some(last) if last.at >= at => Err(FrameError::Time { last: last.at, found: at }),
            _ => Ok(()),
        }
    }

    fn number(&self) -> usize {
        self.frames.len() - 1
    }

    fn start(&mut self, at: Timestamp, pyramid: &Arc<Pyramid>, outcome: &mut FrameOutcome) {
        let before = self.clock.secs();
        let number = self.number();
        match self.initializer.add(number, at, pyramid, &mut self.rng) {
            StartStep::Waiting(wait) => outcome.state = TrackingState::Starting(wait),
            StartStep::Started(started) => self.adopt(*started, outcome),
        }
        outcome.tracking.add("start map", self.clock.secs() - before);
    }

    /// Takes over a started map.
    fn adopt(&mut self, started: StartedMap, outcome: &mut FrameOutcome) {
        let StartedMap { map, first, second, frame, between } = started;
        self.map = map;
        self.frames[self.map.keyframe(first).frame].place = Some((first, Rigid3::identity()));
        let world_from_first = self.map.keyframe(first).camera_from_world().inverse();
        for (number, pose) in between {
            self.frames[number].place = Some((first, pose * world_from_first));
        }
        let number = self.number();
        self.frames[number].place = Some((second, Rigid3::identity()));
        let mut mapper = Mapper::new(&self.camera, &self.config, second);
        mapper.populate(&mut self.map, &[second, first]);
        outcome.state = TrackingState::Tracking(Quality::Good);
        outcome.camera_from_world = Some(frame.camera_from_world);
        outcome.matches = (frame.features.len(), frame.features.len());
        self.tracker.restart_from(frame);
        self.mapper = Some(mapper);
        self.started_at = number;
        self.num_bad = 0;
        self.is_lost = false;
    }

    fn track(&mut self, at: Timestamp, pyramid: &Arc<Pyramid>, outcome: &mut FrameOutcome) {
        let before = self.clock.secs();
        let number = self.number();
        let report = self.tracker.track(&self.map, &Incoming { number, at, pyramid }, &mut self.rng);
        outcome.tracking.add("track", self.clock.secs() - before);
        match report {
            Some(report) if report.quality != Quality::Bad => {
                self.num_bad = 0;
                self.accept(report, outcome);
            }
            report => {
                outcome.matches = report.map_or((0, 0), |r| (r.num_searched, r.num_matched));
                outcome.state = TrackingState::Tracking(Quality::Bad);
                self.num_bad += 1;
                if self.num_bad >= self.config.tracking.max_bad_frames {
                    self.lose();
                    outcome.state = TrackingState::Lost;
                }
            }
        }
    }

    /// Takes over a tracked frame and lets the mapper work on it.
    fn accept(&mut self, report: TrackReport, outcome: &mut FrameOutcome) {
        let Some(mapper) = &mut self.mapper else { return };
        outcome.state = TrackingState::Tracking(report.quality);
        outcome.camera_from_world = Some(report.frame.camera_from_world);
        outcome.matches = (report.num_searched, report.num_matched);
        let is_converged = |id| self.map.landmark(id).is_converged();
        outcome.features = report.frame.features.iter().map(|f| (f.px, is_converged(f.landmark))).collect();
        self.map.count_matches(&report);
        let number = report.frame.number;
        let wants = mapper.wants_keyframe(&self.map, &report);
        let (frame, local) = (report.frame, report.local_map.landmarks);
        let before = self.clock.secs();
        let anchor = if wants && report.quality == Quality::Good {
            outcome.mapping =
                mapper.add_keyframe(&mut self.map, &frame, &local, self.clock, &mut outcome.mapping_times);
            self.tracker.accept(frame);
            let anchor = mapper.last_keyframe();
            self.tracker.correct_last(*self.map.keyframe(anchor).camera_from_world());
            self.frames[number].place = Some((anchor, Rigid3::identity()));
            return;
        } else {
            outcome.mapping = mapper.add_frame(&mut self.map, &frame);
            outcome.mapping_times.add("update points", self.clock.secs() - before);
            mapper.last_keyframe()
        };
        let from_anchor = frame.camera_from_world * self.map.keyframe(anchor).camera_from_world().inverse();
        self.frames[number].place = Some((anchor, from_anchor));
        self.tracker.accept(frame);
    }

    /// Gives up the pose. A map that has only just been started is given up with it.
    fn lose(&mut self) {
        self.num_bad = 0;
        if self.number() < self.started_at + PROBATION_FRAMES {
            self.mapper = None;
            self.map = Map::new();
            self.frames.iter_mut().for_each(|frame| frame.place = None);
            self.initializer.reset();
            self.tracker.forget();
            return;
        }
        self.is_lost = true;
    }

    fn relocalize(&mut self, at: Timestamp, pyramid: &Arc<Pyramid>, outcome: &mut FrameOutcome) {
        let before = self.clock.secs();
        let number = self.number();
        let incoming = Incoming { number, at, pyramid };
        let found = self.relocator.attempt(&self.map, &self.tracker, &incoming, &mut self.rng);
        outcome.tracking.add("relocalize", self.clock.secs() - before);
        let Some((report, keyframe)) = found else { return };
        self.is_lost = false;
        outcome.is_relocalized = true;
        self.tracker.forget();
        if let Some(mapper) = &mut self.mapper {
            mapper.go_on_from(keyframe);
        }
        self.accept(report, outcome);
    }
}
