//! The tracking side: start, tracking, relocalization, and the trajectory. It reads the map and sends orders to change it.

mod begin;
mod cross;
mod find;
mod follow;
mod supposed;
mod trajectory;
mod unsettled;
mod update;

use std::sync::Arc;

use visloc_core::{Clock, GrayImage, Rng, RngTree, Timestamp, geom::Camera};

use crate::{
    backfill::Backfill,
    config::SlamConfig,
    frame_log::FrameLog,
    image::Pyramid,
    map::{Crossing, KeyframeId, Map, MapId, Packing, SessionCamera},
    mapping::KeyframeRule,
    odometry::{CameraMotion, MetricScale, OdomFromCamera, OdomPose},
    outcome::{FrameError, FrameOutcome, FramePose},
    recognize::Relocator,
    schedule::{Job, Order},
    shutter::{Exposure, Readout},
    start::Initializer,
    timing::StageTimer,
    track::{Incoming, Tracker},
};
use supposed::Supposed;
use unsettled::Unsettled;

/// What tracking is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// There is no map.
    Starting,
    /// The camera is followed.
    Tracking,
    /// The camera is lost: it is looked for in all maps and, after a while, a new map is started.
    Lost,
}

/// What becomes of the maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Keeping {
    /// They grow and are corrected, and a lost camera starts new ones.
    Growing,
    /// Views are added around those of an earlier session, which stay as they are.
    Extending,
    /// They stay as they are.
    Fixed,
}

/// The tracking side of the system.
#[derive(Debug)]
pub(crate) struct FrontEnd {
    pub camera: Camera,
    /// The camera as it was at first.
    pub calibrated: Camera,
    /// How long it takes to expose an image, as the map tells it.
    pub readout: Readout,
    config: SlamConfig,
    rng: Rng,
    pub clock: Clock,
    /// How images that have rested are packed.
    pub packing: Option<Packing>,
    /// The map as tracking sees it.
    pub map: Map,
    /// Grows with every map that is started and when all are given up.
    epoch: usize,
    initializer: Initializer,
    tracker: Tracker,
    relocator: Relocator,
    backfill: Backfill,
    /// Frames that the map and an earlier one know, of which the mapper has not been told.
    crossings: Vec<Crossing>,
    rule: KeyframeRule,
    pub frames: FrameLog,
    /// While the whole map is being adjusted: the frames that were tracked in it since that began.
    unsettled: Option<Vec<Unsettled>>,
    phase: Phase,
    num_bad: usize,
    started_at: usize,
    /// The map that was started then.
    started_map: Option<MapId>,
    keeping: Keeping,
    /// Whether the place where the camera is followed may be the wrong one.
    is_in_doubt: bool,
    /// The newest keyframe, or an earlier one that covers the view.
    anchor: KeyframeId,
    /// The keyframe that the last frame hangs on: the same, or, since the whole map was being adjusted, the one that shows most of what was found.
    hangs_on: KeyframeId,
    /// Scale of that keyframe in the map as tracking sees it.
    anchor_scale: f64,
    /// Whether the mapper still works on a start or a keyframe, or gives a map up.
    awaits_keyframe: bool,
    /// Where the camera is only supposed to be.
    supposed: Option<Supposed>,
    /// Whether it was not where it was supposed to be: until it is found for sure, or a map is started, nothing is supposed.
    is_refuted: bool,
    /// When the camera was lost.
    lost_at: Timestamp,
    /// When there was odometry last.
    odometry_at: Option<Timestamp>,
    /// Number of the stretch of odometry.
    stretch: usize,
}

/// Frames within which a loss means that the start was wrong.
const PROBATION_FRAMES: usize = 30;

impl FrontEnd {
    /// For one camera. The parameters have been checked.
    pub fn new(camera: &Camera, config: &SlamConfig, seed: u64) -> Self {
        Self {
            camera: *camera,
            calibrated: *camera,
            readout: Readout::default(),
            config: config.clone(),
            rng: RngTree::new(seed).stream("slam", 0),
            clock: Clock::still(),
            packing: None,
            map: Map::new(),
            epoch: 0,
            initializer: Initializer::new(camera, config),
            tracker: Tracker::new(camera, &config.tracking, &config.features),
            relocator: Relocator::new(camera, config),
            backfill: Backfill::new(camera, config, seed),
            crossings: Vec::new(),
            rule: KeyframeRule::new(&config.mapping, f64::from(camera.size_px().0)),
            frames: FrameLog::default(),
            unsettled: None,
            phase: Phase::Starting,
            num_bad: 0,
            started_at: 0,
            started_map: None,
            keeping: Keeping::Growing,
            is_in_doubt: false,
            anchor: KeyframeId::default(),
            hangs_on: KeyframeId::default(),
            anchor_scale: 1.0,
            awaits_keyframe: false,
            supposed: None,
            is_refuted: false,
            lost_at: Timestamp::default(),
            odometry_at: None,
            stretch: 0,
        }
    }

    /// With maps of an earlier session, in which the camera is to be found, and what they know of it.
    pub fn resume(
        map: &Map,
        known: &SessionCamera,
        config: &SlamConfig,
        seed: u64,
        keeping: Keeping,
    ) -> Self {
        let SessionCamera { calibrated, readout, .. } = *known;
        let phase = Phase::Lost;
        let mut front_end = Self {
            calibrated,
            readout,
            map: map.clone(),
            phase,
            keeping,
            ..Self::new(&known.camera, config, seed)
        };
        if keeping == Keeping::Extending {
            front_end.relocator.doubt();
        }
        front_end
    }

    /// Takes the next frame; says what became of it and what the mapper should do.
    pub fn add_frame(
        &mut self,
        at: Timestamp,
        image: GrayImage,
        odom_from_camera: Option<OdomFromCamera>,
    ) -> Result<(FrameOutcome, Option<Order>), FrameError> {
        self.check_frame(at, &image)?;
        let mut timer = StageTimer::start(self.clock.clone());
        if self.frames.poses().is_empty() {
            self.lost_at = at;
        }
        self.stretch += usize::from(odom_from_camera.is_none());
        self.odometry_at = odom_from_camera.map(|_| at).or(self.odometry_at);
        let stretch = self.stretch;
        let odometry = odom_from_camera
            .filter(|_| self.uses_odometry())
            .map(|odom_from_camera| OdomPose { odom_from_camera, stretch });
        self.frames.push(FramePose { odometry, ..FramePose::unknown(at) });
        let number = self.number();
        let mut pyramid = Arc::new(Pyramid::new(image, self.config.features.pyramid_levels));
        timer.end("pyramid");
        let mut readout = Readout::default();
        let as_taken = Incoming { odometry, ..Incoming::of_image(number, at, &pyramid) };
        if let Some(put_right) = self.put_right(&as_taken) {
            (pyramid, readout) = (Arc::new(put_right), self.readout);
            timer.end("rolling shutter");
        }
        let incoming = Incoming { number, at, pyramid: &pyramid, odometry, readout };
        let mut outcome = FrameOutcome::default();
        let job = match self.phase {
            Phase::Starting => self.start(&incoming, &mut outcome, &mut timer),
            Phase::Tracking => self.track(&incoming, &mut outcome, &mut timer),
            Phase::Lost => self.relocalize(&incoming, &mut outcome, &mut timer),
        };
        outcome.tracking = timer.finish();
        let job = job.filter(|_| self.supposed.is_none());
        Ok((outcome, job.map(|job| self.order(job))))
    }

    /// The image as it would be if all of it had been exposed at once; `None` where the camera does so, or is not followed.
    fn put_right(&self, incoming: &Incoming<'_>) -> Option<Pyramid> {
        if self.readout.is_at_once() || self.phase != Phase::Tracking {
            return None;
        }
        let num_levels = self.config.features.pyramid_levels;
        let image = incoming.pyramid.level(0);
        let at_once = |motion| {
            Pyramid::new(Exposure { motion, readout: self.readout }.at_once(image, &self.camera), num_levels)
        };
        // As it moved before, and then as it has moved since.
        let pyramid = Arc::new(at_once(self.tracker.motion_before(&self.map)?));
        let motion = self.tracker.motion_now(&self.map, &Incoming { pyramid: &pyramid, ..*incoming })?;
        Some(at_once(motion))
    }

    /// What the mapper does when no more images come.
    pub fn completion(&self) -> Order {
        self.order(Job::Complete)
    }

    fn order(&self, job: Job) -> Order {
        Order { epoch: self.epoch, clock: self.clock.clone(), packing: self.packing.clone(), job }
    }

    fn check_frame(&self, at: Timestamp, image: &GrayImage) -> Result<(), FrameError> {
        let (width, height) = self.camera.size_px();
        let (expected, found) = ((width as usize, height as usize), (image.width(), image.height()));
        if expected != found {
            return Err(FrameError::Size { expected, found });
        }
        match self.frames.poses().last() {
            Some(last) if last.at >= at => Err(FrameError::Time { last: last.at, found: at }),
            _ => Ok(()),
        }
    }

    fn number(&self) -> usize {
        self.frames.len() - 1
    }

    /// Whether odometry is of use: the unit of length of a map that was made without is not known. Beside a fixed map it has the unit of that.
    fn uses_odometry(&self) -> bool {
        self.phase != Phase::Tracking
            || self.keeping == Keeping::Extending
            || self.map.is_in_meters(self.map.active())
    }

    /// Motion of the camera from one frame to another by odometry, meters.
    fn odometry(&self, first: usize, second: usize) -> Option<CameraMotion> {
        let pose = |number| self.frames.get(number)?.odometry;
        pose(first)?.motion_to(&pose(second)?)
    }

    /// Whether the place is in doubt from now on: the camera is looked for in the whole of a fixed map then, though it is followed.
    pub fn set_doubt(&mut self, is_in_doubt: bool) {
        self.is_in_doubt = is_in_doubt && self.keeping != Keeping::Growing;
    }

    /// Brings all maps that were made with odometry to meters by the whole of it. Those that are fixed have their unit.
    pub fn make_metric(&mut self) {
        if self.map.has_fixed() {
            return;
        }
        for map in self.map.maps() {
            if let Some(scale) = MetricScale::of_map(&self.map, map) {
                self.map.enlarge(map, 1.0 / scale.units_per_meter);
            }
        }
    }
}
