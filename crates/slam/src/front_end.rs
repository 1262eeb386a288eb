//! The tracking side: start, tracking, relocalization, and the trajectory. It reads the map and sends orders to change it.

use std::sync::Arc;

use visloc_core::{
    Clock, GrayImage, Rng, RngTree, Timestamp,
    geom::{Camera, CameraFrame, Rigid3},
};

use crate::{
    atlas::Similarity,
    backfill::Backfill,
    config::{SlamConfig, TrackingConfig},
    frame_log::FrameLog,
    image::Pyramid,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map, MapId, SessionCamera},
    mapping::{KeyframeDecision, KeyframeRule},
    odometry::{CameraMotion, MetricScale, OdomFromCamera, OdomPose},
    outcome::{FrameError, FrameOutcome, FramePose, Mapped, TrackingState, TrajectoryPose},
    recognize::{Located, Refusal, Relocator, are_apart},
    schedule::{FrameJob, Job, Order, Update},
    start::{Initializer, StartStep, StartedMap},
    timing::StageTimer,
    track::{FrameWork, Incoming, Quality, TrackReport, Tracker, focal_px},
};

/// Landmarks from which on a place is sure enough to go on mapping there, in units of the fewest that it is recognized by.
const SURE: usize = 2;
/// Longest time for which somebody carries a robot, seconds.
const MOST_IN_THE_AIR_SECS: f64 = 10.0;

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
    camera: Camera,
    /// The camera as it was at first.
    calibrated: Camera,
    config: SlamConfig,
    rng: Rng,
    clock: Clock,
    /// The map as tracking sees it.
    map: Map,
    /// Grows with every map that is started and when all are given up.
    epoch: usize,
    initializer: Initializer,
    tracker: Tracker,
    relocator: Relocator,
    backfill: Backfill,
    rule: KeyframeRule,
    frames: FrameLog,
    phase: Phase,
    num_bad: usize,
    started_at: usize,
    /// The map that was started then.
    started_map: Option<MapId>,
    keeping: Keeping,
    /// Whether the place where the camera is followed may be the wrong one.
    is_in_doubt: bool,
    /// The keyframe that new frames hang on: the newest one, or an earlier one that covers the view.
    anchor: KeyframeId,
    /// Scale of that keyframe in the map as tracking sees it.
    anchor_scale: f64,
    /// Whether the mapper still works on a start or a keyframe, or gives a map up.
    awaits_keyframe: bool,
    /// When the camera was lost.
    lost_at: Timestamp,
    /// When there was odometry last.
    odometry_at: Option<Timestamp>,
    /// Number of the stretch of odometry.
    stretch: usize,
}

/// Landmarks of a fixed map that show its place well, in units of the fewest from which a pose counts: as long as an image has as many,
/// nothing is added around it.
const ENOUGH_FIXED: usize = 5;
/// Images from one look elsewhere to the next while the place is in doubt: several a second, and one costs as much as some tracked images.
const LOOK_EVERY: usize = 5;
/// Frames within which a loss means that the start was wrong.
const PROBATION_FRAMES: usize = 30;

impl FrontEnd {
    /// For one camera. The parameters have been checked.
    pub fn new(camera: &Camera, config: &SlamConfig, seed: u64) -> Self {
        Self {
            camera: *camera,
            calibrated: *camera,
            config: config.clone(),
            rng: RngTree::new(seed).stream("slam", 0),
            clock: Clock::still(),
            map: Map::new(),
            epoch: 0,
            initializer: Initializer::new(camera, config),
            tracker: Tracker::new(camera, &config.tracking, &config.features),
            relocator: Relocator::new(camera, config),
            backfill: Backfill::new(camera, config),
            rule: KeyframeRule::new(&config.mapping, f64::from(camera.size_px().0)),
            frames: FrameLog::default(),
            phase: Phase::Starting,
            num_bad: 0,
            started_at: 0,
            started_map: None,
            keeping: Keeping::Growing,
            is_in_doubt: false,
            anchor: KeyframeId::default(),
            anchor_scale: 1.0,
            awaits_keyframe: false,
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
        let calibrated = known.calibrated;
        let phase = Phase::Lost;
        let mut front_end =
            Self { calibrated, map: map.clone(), phase, keeping, ..Self::new(&known.camera, config, seed) };
        if keeping == Keeping::Extending {
            front_end.relocator.doubt();
        }
        front_end
    }

    pub fn set_clock(&mut self, clock: Clock) {
        self.clock = clock;
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    pub fn calibrated(&self) -> &Camera {
        &self.calibrated
    }

    pub fn remember_frames(&mut self, least: usize) {
        self.frames.remember(least);
    }

    pub fn map(&self) -> &Map {
        &self.map
    }

    pub fn frames(&self) -> &FrameLog {
        &self.frames
    }

    /// Poses of all frames that have one, with all corrections of the map so far.
    pub fn trajectory(&self) -> Vec<TrajectoryPose> {
        let pose = |frame: &FramePose| {
            let world_from_camera = self.camera_from_world(frame)?.inverse();
            let map = self.map.map_of(frame.place?.0)?;
            let FramePose { at, is_filled_in, is_carried, .. } = *frame;
            Some(TrajectoryPose { at, world_from_camera, map, is_filled_in, is_carried })
        };
        self.frames.poses().iter().filter_map(pose).collect()
    }

    fn camera_from_world(&self, frame: &FramePose) -> Option<CameraFromWorld> {
        let (keyframe, camera_from_keyframe) = frame.place?;
        self.map.map_of(keyframe)?;
        Some(self.map.pose_on(keyframe, &camera_from_keyframe, frame.scale))
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
        let pyramid = Arc::new(Pyramid::new(image, self.config.features.pyramid_levels));
        timer.end("pyramid");
        if self.frames.poses().is_empty() {
            self.lost_at = at;
        }
        self.stretch += usize::from(odom_from_camera.is_none());
        self.odometry_at = odom_from_camera.map(|_| at).or(self.odometry_at);
        let stretch = self.stretch;
        let odometry = odom_from_camera
            .filter(|_| self.is_in_meters())
            .map(|odom_from_camera| OdomPose { odom_from_camera, stretch });
        self.frames.push(FramePose { odometry, ..FramePose::unknown(at) });
        let incoming = Incoming { number: self.number(), at, pyramid: &pyramid, odometry };
        let mut outcome = FrameOutcome::new();
        let job = match self.phase {
            Phase::Starting => self.start(&incoming, &mut outcome, &mut timer),
            Phase::Tracking => self.track(&incoming, &mut outcome, &mut timer),
            Phase::Lost => self.relocalize(&incoming, &mut outcome, &mut timer),
        };
        outcome.tracking = timer.finish();
        Ok((outcome, job.map(|job| Order { epoch: self.epoch, clock: self.clock.clone(), job })))
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

    /// Whether odometry is of use: the unit of length of a map that was made without is not known.
    fn is_in_meters(&self) -> bool {
        self.phase != Phase::Tracking || self.map.is_in_meters(self.map.active())
    }

    /// Whether the robot's feet were in the air just now: where it is put down is another place, and what it saw until then tells no
    /// lengths. Without odometry for longer than it takes to carry a robot, there is none any more.
    fn was_in_the_air(&self, at: Timestamp) -> bool {
        self.odometry_at.is_some_and(|last| at.secs_since(last) < MOST_IN_THE_AIR_SECS)
            && self.frames.poses().iter().rev().take(2).any(|frame| frame.odometry.is_none())
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

    fn start(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        if self.was_in_the_air(incoming.at) {
            self.initializer.reset();
        }
        let step = self.initializer.add(incoming, &mut self.rng);
        timer.end("start map");
        match step {
            StartStep::Waiting(wait) => {
                self.backfill.keep(incoming);
                outcome.state = TrackingState::Starting(wait);
                None
            }
            StartStep::Started(mut started) => {
                let is_only = self.map.maps().is_empty();
                self.measure_start(&mut started);
                self.adopt(&started, outcome);
                Some(Job::Adopt { started, is_only })
            }
        }
    }

    /// Brings a started map to meters if odometry tells how long its baseline is; if not, odometry is of no use in it.
    fn measure_start(&self, started: &mut StartedMap) {
        let first = started.map.keyframe(started.first);
        let pose = *first.camera_from_world();
        let units = (started.map.keyframe(started.second).center_in_world() - first.center_in_world()).norm();
        match self.odometry(first.frame, started.frame.number) {
            Some(motion) => {
                let meters_per_unit = motion.translation().norm() / units.max(f64::MIN_POSITIVE);
                started.move_by(&Similarity::between(&pose, &pose, meters_per_unit));
            }
            None => started.forget_odometry(),
        }
    }

    /// Goes on with a started map. Earlier ones stay as they are.
    fn adopt(&mut self, started: &StartedMap, outcome: &mut FrameOutcome) {
        let StartedMap { map, first, second, frame, between } = started;
        let offsets = self.map.append(map);
        self.epoch += 1;
        let (first_id, second_id) = (offsets.keyframe(*first), offsets.keyframe(*second));
        self.anchor_scale = self.map.scale_of(second_id);
        self.place(map.keyframe(*first).frame, (first_id, Rigid3::identity()));
        let world_from_first = map.keyframe(*first).camera_from_world().inverse();
        for (number, pose) in between {
            self.place(*number, (first_id, *pose * world_from_first));
        }
        self.backfill.start(first_id, second_id);
        let number = self.number();
        for earlier in std::iter::once(map.keyframe(*first).frame).chain(between.iter().map(|b| b.0)) {
            if let Some(pose) = self.frames.get_mut(earlier) {
                pose.is_filled_in = true;
            }
        }
        self.place(number, (second_id, Rigid3::identity()));
        outcome.state = TrackingState::Tracking(Quality::Good);
        outcome.camera_from_world = Some(frame.camera_from_world);
        outcome.map = Some(self.map.active());
        outcome.matches = (frame.features.len(), frame.features.len());
        let mut frame = frame.clone();
        for feature in &mut frame.features {
            feature.landmark = offsets.landmark(feature.landmark);
        }
        self.tracker.restart_from(frame);
        self.rule.restart();
        self.anchor = second_id;
        self.awaits_keyframe = true;
        self.started_at = number;
        self.started_map = Some(self.map.active());
        self.num_bad = 0;
        self.phase = Phase::Tracking;
    }

    fn track(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        let report = self.tracker.track(&self.map, incoming, &mut FrameWork { rng: &mut self.rng, timer });
        match report {
            Some(report) if report.quality != Quality::Bad => {
                self.num_bad = 0;
                if let Some(job) = self.look_elsewhere(incoming, &report, outcome, timer) {
                    return Some(job);
                }
                Some(self.accept(report, outcome, timer))
            }
            Some(report) if let Some(moved) = self.tracker.moved(incoming) => {
                self.num_bad = if self.contradicts(&report) { self.num_bad + 1 } else { 0 };
                if self.num_bad >= self.config.tracking.max_bad_frames
                    && let Some(job) = self.found_elsewhere(incoming, outcome, timer)
                {
                    return Some(job);
                }
                Some(self.carry(report, &moved, outcome, timer))
            }
            report => {
                outcome.matches = report.map_or((0, 0), |r| (r.num_searched, r.num_matched));
                outcome.state = TrackingState::Tracking(Quality::Bad);
                self.num_bad += 1;
                // The camera may have been carried away: in a fixed map there is nothing that could be lost by looking elsewhere.
                if self.keeping != Keeping::Growing
                    && let Some(job) = self.found_elsewhere(incoming, outcome, timer)
                {
                    return Some(job);
                }
                if self.num_bad < self.config.tracking.max_bad_frames {
                    return None;
                }
                outcome.state = TrackingState::Lost;
                self.lose(incoming.at)
            }
        }
    }

    /// Whether a frame does not show what should be in view, enough of it for a good frame: somebody may have carried the camera away.
    /// An image that shows too little says nothing.
    fn contradicts(&self, report: &TrackReport) -> bool {
        let TrackingConfig { min_match_ratio, min_matches, .. } = self.config.tracking;
        report.num_searched as f64 * min_match_ratio >= min_matches as f64 && report.num_matched < min_matches
    }

    /// Looks for the camera in the whole map; only what is found changes anything.
    fn found_elsewhere(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        let located = self.recognize(incoming, timer).ok()?;
        Some(self.go_on_at(located, outcome, timer))
    }

    /// Looks for the camera in the fixed map while its place is in doubt; where more of that map is seen than here, it goes on.
    fn look_elsewhere(
        &mut self,
        incoming: &Incoming<'_>,
        here: &TrackReport,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        if !self.is_in_doubt || !self.number().is_multiple_of(LOOK_EVERY) {
            return None;
        }
        let mut aside = StageTimer::start(Clock::still());
        let mut work = FrameWork { rng: &mut self.rng, timer: &mut aside };
        let is_candidate = |id| self.map.is_fixed(id);
        let found = self.relocator.attempt_among(&self.map, is_candidate, incoming, &mut work);
        timer.end("relocalize");
        let located = found.ok()?;
        let num_fixed = |report: &TrackReport| {
            report.frame.features.iter().filter(|f| self.map.is_fixed_landmark(f.landmark)).count()
        };
        let is_better =
            num_fixed(&located.report) > num_fixed(here) && are_apart(&self.map, &located.report, here);
        is_better.then(|| self.go_on_at(located, outcome, timer))
    }

    /// Looks for the keyframe of any map that shows the place.
    fn recognize(
        &mut self,
        incoming: &Incoming<'_>,
        timer: &mut StageTimer,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        let mut aside = StageTimer::start(Clock::still());
        let mut work = FrameWork { rng: &mut self.rng, timer: &mut aside };
        let found = self.relocator.attempt(&self.map, incoming, &mut work);
        timer.end("relocalize");
        match found {
            Ok(located) if self.keeping == Keeping::Growing && !self.is_sure(&located) => {
                let (num, of) = (located.report.num_matched, located.report.num_searched);
                Err(Some((located.keyframe, Refusal::FewFound { num, of })))
            }
            found => found,
        }
    }

    /// Whether more is seen of a place than of a thing that may be there twice, such as a door: what goes on at a wrong place bends the map.
    fn is_sure(&self, located: &Located) -> bool {
        let num = located.report.num_matched;
        num >= SURE * self.config.relocation.min_matches && num > located.num_elsewhere
    }

    /// Lets odometry carry the pose of the last frame on, where the image tells too little. Mapping goes on: what comes into view is
    /// known soon.
    fn carry(
        &mut self,
        mut report: TrackReport,
        moved: &CameraMotion,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Job {
        let number = report.frame.number;
        if let Some(last) = self.tracker.last() {
            report.frame.camera_from_world = *moved * last.camera_from_world;
        }
        report.frame.features.clear();
        (report.num_matched, report.num_converged) = (0, 0);
        let job = self.accept(report, outcome, timer);
        outcome.state = TrackingState::Carried;
        if let Some(frame) = self.frames.get_mut(number) {
            frame.is_carried = true;
        }
        job
    }

    /// Takes over a tracked frame and decides whether it should become a keyframe.
    fn accept(&mut self, report: TrackReport, outcome: &mut FrameOutcome, timer: &mut StageTimer) -> Job {
        outcome.state = TrackingState::Tracking(report.quality);
        outcome.camera_from_world = Some(report.frame.camera_from_world);
        outcome.covariance = report.covariance;
        outcome.map = Some(self.map.active());
        outcome.matches = (report.num_searched, report.num_matched);
        let is_converged = |id| self.map.landmark(id).is_converged();
        outcome.features = report.frame.features.iter().map(|f| (f.px, is_converged(f.landmark))).collect();
        let is_fixed = |id: &LandmarkId| self.map.is_fixed_landmark(*id);
        outcome.fixed = report.frame.features.iter().map(|f| f.landmark).filter(is_fixed).collect();
        let shows_enough = self.keeping == Keeping::Extending
            && outcome.fixed.len() >= ENOUGH_FIXED * self.config.tracking.min_matches;
        let decision = if self.keeping == Keeping::Fixed || shows_enough {
            report
                .local_map
                .keyframes
                .first()
                .map_or(KeyframeDecision::Stay, |id| KeyframeDecision::GoBackTo(*id))
        } else if self.awaits_keyframe {
            KeyframeDecision::Stay
        } else {
            self.rule.decide(&self.map, self.anchor, &report, focal_px(&self.camera))
        };
        if let KeyframeDecision::GoBackTo(earlier) = decision {
            self.anchor = earlier;
        }
        let makes_keyframe = decision == KeyframeDecision::Make;
        self.anchor_scale = self.map.scale_of(self.anchor);
        let anchor_from_world = self.map.pose_of(self.anchor);
        let from_anchor = report.frame.camera_from_world * anchor_from_world.inverse();
        self.place(report.frame.number, (self.anchor, from_anchor));
        self.tracker.accept(report.frame.clone());
        self.awaits_keyframe |= makes_keyframe;
        self.fill_back();
        timer.end("keyframe decision");
        let (anchor, anchor_scale) = (self.anchor, self.anchor_scale);
        Job::Frame(Box::new(FrameJob { report, makes_keyframe, anchor, anchor_from_world, anchor_scale }))
    }

    /// Finds the pose of one of the frames before the start, once the map has proved to be right.
    fn fill_back(&mut self) {
        if self.number() < self.started_at + PROBATION_FRAMES / 2 {
            return;
        }
        if let Some((number, place)) = self.backfill.next(&self.map, &mut self.rng)
            && self.frames.get_mut(number).is_some_and(|frame| frame.place.is_none() || frame.is_carried)
        {
            let scale = std::mem::replace(&mut self.anchor_scale, self.map.scale_of(place.0));
            self.place(number, place);
            self.anchor_scale = scale;
            if let Some(frame) = self.frames.get_mut(number) {
                frame.is_filled_in = true;
            }
        }
    }

    /// Gives up the pose. A map that has only just been started is given up with it.
    fn lose(&mut self, at: Timestamp) -> Option<Job> {
        self.num_bad = 0;
        self.lost_at = at;
        self.initializer.reset();
        let was_active = self.map.active();
        let is_young =
            self.started_map == Some(was_active) && self.number() < self.started_at + PROBATION_FRAMES;
        self.phase = Phase::Lost;
        if !is_young {
            return None;
        }
        self.tracker.forget();
        if self.map.maps() != [was_active] {
            self.map.give_up(was_active);
            self.awaits_keyframe = true;
            return Some(Job::GiveUp(was_active));
        }
        self.phase = Phase::Starting;
        self.map = Map::new();
        self.epoch += 1;
        self.frames.iter_mut().for_each(|frame| frame.place = None);
        None
    }

    fn relocalize(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        match self.recognize(incoming, timer) {
            Ok(located) => Some(self.go_on_at(located, outcome, timer)),
            Err(refused) => {
                // While the mapper is at work, the numbers of new keyframes are not known yet.
                let is_time = incoming.at.secs_since(self.lost_at) >= self.config.relocation.new_map_secs;
                let job = if is_time && !self.awaits_keyframe && self.keeping == Keeping::Growing {
                    self.start(incoming, outcome, timer)
                } else {
                    None
                };
                if job.is_none() {
                    outcome.state = TrackingState::Lost;
                    outcome.refusal = refused.map(|(_, reason)| reason);
                }
                job
            }
        }
    }

    /// Goes on where the camera was found.
    fn go_on_at(&mut self, located: Located, outcome: &mut FrameOutcome, timer: &mut StageTimer) -> Job {
        self.phase = Phase::Tracking;
        self.num_bad = 0;
        outcome.is_relocalized = true;
        outcome.num_elsewhere = located.num_elsewhere;
        self.tracker.forget();
        self.initializer.reset();
        self.anchor = located.keyframe;
        self.activate_anchor();
        self.rule.keyframe_made();
        self.accept(located.report, outcome, timer)
    }

    /// Goes on in the map of the keyframe that frames hang on.
    fn activate_anchor(&mut self) {
        if let Some(map) = self.map.map_of(self.anchor) {
            self.map.activate(map);
        }
    }

    /// Gives the map out of hand, so that the mapper need not copy what it changes.
    pub fn release_map(&mut self) {
        self.map = Map::new();
    }

    /// Takes over what the mapper has finished. What belongs to a map that was given up is left out.
    pub fn apply(&mut self, update: Update) -> Option<Mapped> {
        self.set_camera(&update.camera);
        if update.epoch != self.epoch {
            return None;
        }
        let made = update.mapped.report.keyframe;
        if let Some(keyframe) = made {
            self.rehang(update.mapped.frame, keyframe, &update.camera_from_world);
            self.anchor = keyframe;
            self.rule.keyframe_made();
        }
        let scale_before = if made.is_some() { 1.0 } else { self.anchor_scale };
        self.map = update.map;
        if self.phase == Phase::Tracking {
            self.activate_anchor();
            self.anchor_scale = self.map.scale_of(self.anchor);
            self.tracker.scale_motion(self.anchor_scale / scale_before);
        }
        if update.was_awaited {
            self.awaits_keyframe = false;
        }
        if update.has_moved {
            let first = update.mapped.frame.saturating_add(usize::from(update.was_awaited));
            self.correct_last(first, made);
        }
        Some(update.mapped)
    }

    /// Takes over a camera that is known better.
    fn set_camera(&mut self, camera: &Camera) {
        if *camera != self.camera {
            self.camera = *camera;
            self.tracker.set_camera(camera);
            self.relocator.set_camera(camera);
            self.initializer.set_camera(camera);
            self.backfill.set_camera(camera);
        }
    }

    /// Hangs a frame that has become a keyframe on itself, and the frames tracked since then on it, too.
    fn rehang(&mut self, number: usize, keyframe: KeyframeId, camera_from_world: &CameraFromWorld) {
        // The keyframe has just been made: its scale is 1.
        self.anchor_scale = 1.0;
        let world_from_keyframe = camera_from_world.inverse();
        for later in number + 1..self.frames.len() {
            if let Some(pose) = self.frames.get(later).and_then(|frame| self.camera_from_world(frame)) {
                self.place(later, (keyframe, pose * world_from_keyframe));
            }
        }
        self.place(number, (keyframe, Rigid3::identity()));
    }

    /// Notes where a frame is, if it is still remembered.
    fn place(&mut self, number: usize, place: (KeyframeId, Rigid3<CameraFrame, CameraFrame>)) {
        let scale = self.anchor_scale;
        if let Some(frame) = self.frames.get_mut(number) {
            frame.place = Some(place);
            frame.scale = scale;
            frame.is_carried = false;
        }
    }

    /// Takes over the pose of the last frame, from this number on, from the changed map. The very frame that a map was started with keeps its pose:
    /// its landmarks have hardly moved with it.
    fn correct_last(&mut self, first: usize, made: Option<KeyframeId>) {
        let Some(last) = self.tracker.last().map(|last| last.number) else { return };
        let later = self.frames.get(last).filter(|_| last >= first);
        let pose = later.and_then(|frame| self.camera_from_world(frame));
        let pose =
            pose.or_else(|| made.filter(|_| last + 1 == first).map(|keyframe| self.map.pose_of(keyframe)));
        if let Some(pose) = pose {
            self.tracker.correct_last(pose);
        }
    }
}
