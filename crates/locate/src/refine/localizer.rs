//! A localizer whose hypotheses are refined.

use nalgebra::Matrix3;
use visloc_core::{Rng, Timestamp, geom::PlanarPose};

use super::{
    RefinementConfig,
    known::Known,
    likelihood::hidden,
    search::{Candidate, Effort, PlaceSearch, middle},
    tracks::{BIRTH_GATES_PX, Tracks, fullness, says_something},
    turned::Turned,
    turning::{Turning, camera_yaw_rad},
    view::{NEW_VIEW_M, NEW_VIEW_RAD, PresentView, View},
};
use crate::{
    CameraMisalignment, ConfigError, Estimate, Hypothesis, Individual, LOCALIZED_RELIABILITY, Localizer,
    ObservationModel, Reliability, StartPrior, StepInput, estimate::LOST_RELIABILITY,
    observation::features::FeatureModel, odometer::Odometer, per_camera::OtherCameras,
    reliability::blind_share, vision::Percept,
};

/// Longest time between two images that is taken for one step, seconds.
const MAX_STEP_SECS: f64 = 1.0;
/// A hypothesis less probable than this is not worth a track.
const MIN_PROBABILITY: f64 = 0.02;
/// Poses weighed and places kept in one step while localized, and places kept while not.
const SEARCH: Effort = Effort { num_poses: 40, num_kept: 1 };
const DEEP_PLACES: usize = 6;
/// While there is no track at all on a field, an image is searched this much more: what is found then is not behind anything.
const FIRST_SEARCH: usize = 10;
/// Places at which a track may begin in one step while localized.
const BIRTHS: usize = 1;
/// A track confirmed this far needs no prior any more.
const ESTABLISHED: f64 = 0.9;
/// Below [`LOST_RELIABILITY`] for this long, the robot is lost.
const LOST_SECS: f64 = 0.2;

/// What is followed from image to image of one camera.
#[derive(Debug, Clone, Copy, Default)]
struct Gaze {
    /// When it took its last image.
    at: Option<Timestamp>,
    turning: Turning,
    /// Direction of the camera in the last image, seen from where the odometry began, radians, and place.
    last: Option<PlanarPose>,
    view: PresentView,
    /// When an image last had enough features to say anything.
    showed_something_at: Option<Timestamp>,
    /// Where places look alike, the localizer below and the search for places take turns: whether it was the former's in the last
    /// image.
    is_search_turn: bool,
}

/// Tracks the hypotheses of another localizer.
pub struct Refined {
    config: RefinementConfig,
    pub(super) search: Box<dyn Localizer>,
    pub(super) model: Box<dyn FeatureModel>,
    pub(super) places: PlaceSearch,
    /// Where tracks may begin in this step.
    candidates: Vec<Candidate>,
    /// The image as it is with the camera turned.
    turned: Turned,
    /// Whose turn it is among them.
    turn: usize,
    tracks: Tracks,
    /// The camera of the last image, and its axes on the robot.
    camera_index: usize,
    camera_axes: Matrix3<f64>,
    gaze: Gaze,
    other_gazes: OtherCameras<Gaze>,
    /// Where places look alike: the answer for a robot that may be anywhere.
    middle: Option<PlanarPose>,
    reliability: Reliability,
    odometer: Odometer,
    winner: Option<(u64, PlanarPose)>,
    max_jump_m: f64,
    known: Known,
    has_landmarks: bool,
    /// Seconds without a pose that can be relied on.
    lost_secs: f64,
    /// Seconds since an image last said anything.
    blind_secs: f64,
    /// The same, as many times as long as an image that shows nothing is more probable somewhere else than at the place of the best track.
    doubtful_secs: f64,
    estimate: Estimate,
}

visloc_core::debug_shows!([] Refined { config, winner });

impl Refined {
    /// Refines what `search` finds; `features` are matched to the map, `pixels` weigh places.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(
        config: RefinementConfig,
        search: Box<dyn Localizer>,
        features: Box<dyn FeatureModel>,
        pixels: Box<dyn ObservationModel>,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            camera_index: 0,
            camera_axes: Matrix3::identity(),
            gaze: Gaze::default(),
            other_gazes: OtherCameras::none(),
            middle: config.has_look_alikes.then(|| middle(pixels.as_ref())),
            has_landmarks: features.has_landmarks(),
            max_jump_m: pixels.max_jump_m(),
            known: Known::new(StartPrior::Uniform),
            lost_secs: 0.0,
            blind_secs: 0.0,
            doubtful_secs: 0.0,
            reliability: Reliability::new(config.reliability),
            odometer: Odometer::new(config.max_motion_m),
            config,
            search,
            model: features,
            places: PlaceSearch::new(pixels),
            candidates: Vec::new(),
            turned: Turned::default(),
            turn: 0,
            tracks: Tracks::new(&config),
            winner: None,
            estimate: Estimate::unknown(),
        })
    }

    /// Takes up what is known of the image's camera. How long ago it took its last image, seconds.
    fn look_through(&mut self, percept: &Percept) -> f64 {
        let cameras = (self.camera_index, percept.camera_index);
        let axes = *percept.robot_from_camera.rotation();
        self.tracks.look_through(cameras.1, &axes.tr_mul(&self.camera_axes), &self.config);
        self.other_gazes.look_through(&mut self.gaze, cameras, |_| Gaze::default());
        (self.camera_index, self.camera_axes) = (cameras.1, axes);
        let last_at = self.gaze.at.replace(percept.at);
        last_at.map_or(0.0, |last| percept.at.secs_since(last).clamp(0.0, MAX_STEP_SECS))
    }

    /// Whether the last images of another camera show something.
    fn does_another_see(&self, at: Timestamp) -> bool {
        let sees =
            |gaze: &Gaze| gaze.showed_something_at.is_some_and(|then| at.secs_since(then) < MAX_STEP_SECS);
        self.other_gazes.iter().any(|(_, gaze)| sees(gaze))
    }

    fn forget(&mut self) {
        self.tracks.clear();
        self.reliability.reset();
        self.winner = None;
        self.known.forget_last();
        self.estimate.forget();
        if let Some(middle) = self.middle {
            self.estimate.world_from_robot = middle;
        }
    }

    /// How much of an image is new, 0 to 1: what was seen from nearly the same place is no new evidence.
    fn novelty(&mut self, input: &StepInput<'_>) -> f64 {
        if !self.config.has_look_alikes {
            let robot = self.known.start_from_robot();
            let yaw_rad = robot.yaw_rad + camera_yaw_rad(input.percept);
            return self.gaze.view.move_to(&PlanarPose::new(robot.x_m, robot.y_m, yaw_rad));
        }
        let camera_yaw_rad = camera_yaw_rad(input.percept);
        let robot = self.tracks.best().map_or(self.estimate.world_from_robot, |track| track.filter.pose());
        let view = PlanarPose::new(robot.x_m, robot.y_m, robot.yaw_rad + camera_yaw_rad);
        let novelty = self.gaze.last.map_or(1.0, |last| {
            last.distance_m(&view) / NEW_VIEW_M + last.heading_difference_rad(&view) / NEW_VIEW_RAD
        });
        self.gaze.last = Some(view);
        novelty.min(1.0)
    }

    /// How clear an image is, 0 to 1.
    fn clearness(&mut self, input: &StepInput<'_>, secs: f64) -> f64 {
        let rate = self.gaze.turning.rate_rad_per_s(input, secs);
        if self.config.has_look_alikes {
            1.0 / (1.0 + (rate / self.config.blurring_turn_rad_per_s).powi(2))
        } else {
            1.0
        }
    }

    /// The image says nothing: the tracks are followed by the motion alone, and trusted less and less.
    fn go_blind(&mut self) {
        let (secs, from_secs) = (self.odometer.secs(), self.blind_secs);
        self.blind_secs += secs;
        self.tracks.drift(from_secs, self.blind_secs, &self.config);
        let expected_px = self
            .tracks
            .best()
            .map_or(0.0, |best| self.model.expected_px(&best.filter.camera(), best.filter.spread_px()));
        // It may have been carried away at any time since then, after which this image is as good as any other.
        let moved_secs = self.blind_secs / hidden(expected_px);
        let doubtful_secs = moved_secs.max(self.doubtful_secs + secs);
        self.reliability.fade(doubtful_secs - self.doubtful_secs);
        self.doubtful_secs = doubtful_secs;
    }

    fn update_tracks(&mut self, novelty: f64, clearness: f64) {
        let region = self.places.region();
        let view = View {
            novelty,
            clearness,
            has_landmarks: self.has_landmarks,
            is_localized: self.estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY,
            region,
        };
        self.tracks.update(self.model.as_ref(), &self.candidates, &view, &self.known, &self.config);
        self.tracks.leave(&self.places.region());
        if let Some(best) = self.tracks.best()
            && best.confirmed >= ESTABLISHED
        {
            self.known.establish(best.filter.pose(), best.own_share);
            if self.estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY {
                self.tracks.remember_robot();
            }
        }
    }

    fn update_reliability(&mut self, input: &StepInput<'_>, novelty: f64) {
        let shows_landmark = self.has_landmarks && input.percept.is_informative;
        let novelty = if shows_landmark { 1.0 } else { novelty };
        let Some(best) = self.tracks.best() else {
            self.reliability.reset();
            self.winner = None;
            return;
        };
        let mut quality = input.percept.quality;
        if self.config.has_look_alikes {
            // Images of bare walls count for a place that doors have confirmed: bare walls look alike in too many places.
            quality = quality.max(best.seen_doors * fullness(self.model.as_ref()));
        }
        let before = self.reliability;
        self.reliability.update(best.last_agreement, quality, self.odometer.secs());
        if self.reliability.value() > before.value() {
            self.reliability = before.toward(&self.reliability, novelty);
        }
        let pose = best.filter.pose();
        if let Some((id, last)) = self.winner
            && id != best.id
        {
            self.reliability.jump(last.distance_m(&pose), self.max_jump_m);
        }
        self.winner = Some((best.id, pose));
    }

    /// Hypotheses of the search, and places that the features suggest: more of them when lost.
    fn find_candidates(&mut self, percept: &Percept, rng: &mut Rng) {
        if self.config.has_look_alikes && !percept.is_informative {
            return;
        }
        let is_localized = self.estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY;
        let is_first = self.tracks.best().is_none() && !self.config.has_look_alikes;
        let effort = match (is_localized, is_first) {
            (true, _) => SEARCH,
            (false, true) => Effort {
                num_poses: FIRST_SEARCH * self.config.search_poses,
                num_kept: 2 * self.config.max_tracks,
            },
            (false, false) => Effort { num_poses: self.config.search_poses, num_kept: DEEP_PLACES },
        };
        let hypotheses = &self.search.estimate().hypotheses;
        let mount = *self.tracks.mount();
        let (tracks, config) = (&self.tracks, &self.config);
        let is_known = |model: &dyn FeatureModel, pose: &PlanarPose| {
            config.has_look_alikes && tracks.know(model, pose, config)
        };
        let probable = hypotheses.iter().filter(|h| h.probability > MIN_PROBABILITY);
        let probable =
            probable.map(|h| h.world_from_robot).filter(|pose| !is_known(self.model.as_ref(), pose));
        let tilt_rad = mount.tilt_rad;
        self.candidates.extend(probable.map(|world_from_robot| Candidate { world_from_robot, tilt_rad }));
        let num_hypotheses = self.candidates.len();
        self.places.begin();
        let rounds = mount.num_draws(config);
        let num_kept = effort.num_kept;
        let short_list = if self.config.has_look_alikes { num_kept } else { 2 * num_kept };
        let effort = Effort { num_poses: effort.num_poses.div_ceil(rounds), num_kept: short_list };
        for _ in 0..rounds {
            let tilt_rad = mount.draw(rng);
            let percept = self.turned.turn(percept, &tilt_rad);
            self.model.condition_on(percept);
            let model = self.model.as_ref();
            let is_known = |pose: &PlanarPose| is_known(model, pose);
            self.places.search((percept, &tilt_rad), model, effort, is_known, rng);
        }
        if !self.config.has_look_alikes {
            self.model.condition_on(percept);
            self.places.keep_best_matched(self.model.as_ref(), BIRTH_GATES_PX[0], num_kept);
        }
        self.candidates.extend(self.places.found());
        // A hypothesis of the localizer goes on from image to image: it is not found anew in each.
        self.tracks.found(&self.candidates[num_hypotheses..], self.model.as_ref(), config);
        // Each costs a fit, so they take turns; but of the first ones none may get ahead by its turn.
        let max = if is_localized { BIRTHS } else { self.config.max_births };
        let max = if is_first { self.candidates.len() } else { max };
        if self.candidates.len() > max {
            self.turn = (self.turn + max) % self.candidates.len();
            self.candidates.rotate_left(self.turn);
            self.candidates.truncate(max);
        }
    }

    /// Tells the search when what it found does not hold.
    fn doubt(&mut self, secs: f64) {
        self.lost_secs =
            if self.estimate.reliability < LOST_RELIABILITY { self.lost_secs + secs } else { 0.0 };
        if self.lost_secs > LOST_SECS {
            self.search.doubt();
            // Images that show nothing say nothing about the camera either.
            if self.blind_secs == 0.0 {
                self.tracks.doubt_mounts(secs, &self.config);
            }
        }
    }

    fn update_estimate(&mut self) {
        let estimate = &mut self.estimate;
        estimate.hypotheses.clear();
        let Some(best) = self.tracks.best() else {
            estimate.reliability = 0.0;
            estimate.reliability_up_to_symmetry = 0.0;
            return;
        };
        let answer =
            if self.config.has_look_alikes { self.tracks.least_error().unwrap_or(best) } else { best };
        estimate.world_from_robot = answer.filter.pose();
        estimate.covariance = answer.filter.pose_covariance();
        estimate.likelihood = answer.last_agreement;
        for track in self.tracks.iter() {
            let hypothesis = Hypothesis {
                world_from_robot: track.filter.pose(),
                covariance: track.filter.pose_covariance(),
                probability: track.log_odds.exp() * track.own_share,
            };
            if let Some(world_from_robot) = self.model.mirrored(&hypothesis.world_from_robot) {
                let probability = track.log_odds.exp() * (1.0 - track.own_share);
                estimate.hypotheses.push(Hypothesis { world_from_robot, probability, ..hypothesis });
            }
            estimate.hypotheses.push(hypothesis);
        }
        estimate.normalize_hypotheses();
        self.update_trust();
    }

    /// How far the place of the best track can be relied upon: by what one view of it tells, or by what many views have told.
    fn update_trust(&mut self) {
        let Some(best) = self.tracks.best() else { return };
        let spread = (self.config.reliable_spread_m / best.filter.spread_m()).min(1.0);
        let total = self.tracks.total_odds(self.has_landmarks, &self.config);
        // Two that are as probable as each other leave nothing to rely on.
        let undisputed = |probability: f64| (2.0 * probability - 1.0).max(0.0);
        let by_views = self.reliability.value() * (0.5 + 0.5 * best.confirmed);
        let has_look_alikes = self.config.has_look_alikes;
        let trusted = if has_look_alikes {
            by_views
        } else {
            let missed = best.missed();
            // Somebody may have moved the robot since an image last showed anything.
            let not_moved = blind_share(self.doubtful_secs, self.config.reliability.blind_secs);
            let by_view = not_moved * sure((1.0 - missed - best.elsewhere()) / total);
            by_view.max(by_views * sure((1.0 - missed) / total))
        };
        let reliability = |share: f64| {
            let share = if has_look_alikes { share / total } else { share };
            spread * trusted * undisputed(share)
        };
        self.estimate.reliability = reliability(best.own_share);
        self.estimate.reliability_up_to_symmetry = reliability(1.0);
    }
}

/// The reliability of a robot that is at a place with this probability: from 95 % on, so that a robot that is localized (0.6) is elsewhere in
/// one of 50 cases at most.
fn sure(probability: f64) -> f64 {
    (1.0 - 20.0 * (1.0 - probability)).max(0.0)
}

impl Localizer for Refined {
    fn reset(&mut self) {
        self.search.reset();
        self.tracks = Tracks::new(&self.config);
        (self.camera_index, self.gaze, self.other_gazes) = (0, Gaze::default(), OtherCameras::none());
        self.turn = 0;
        (self.lost_secs, self.blind_secs, self.doubtful_secs) = (0.0, 0.0, 0.0);
        self.odometer = Odometer::new(self.config.max_motion_m);
        self.forget();
        self.known = Known::new(StartPrior::Uniform);
    }

    fn reset_to(&mut self, prior: &StartPrior) {
        self.search.reset_to(prior);
        self.forget();
        self.known = Known::new(prior.clone());
    }

    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        let secs_of_camera = self.look_through(input.percept);
        let odometry = self.odometer.update(input.percept.at, input.odometry);
        let secs = self.odometer.secs().min(MAX_STEP_SECS);
        // Both cost as much as all the rest, so they take turns.
        self.gaze.is_search_turn = !(self.config.has_look_alikes && self.gaze.is_search_turn);
        if self.gaze.is_search_turn || input.is_lifted {
            let percept = self.turned.turn(input.percept, &self.tracks.mount().tilt_rad);
            self.search.step(&StepInput { percept, ..*input }, rng);
        }
        if input.is_lifted {
            self.forget();
            return &self.estimate;
        }
        if let Some(step) = odometry.step() {
            self.known.move_by(&step);
        }
        self.tracks.predict(&odometry, secs, &self.config);
        self.candidates.clear();
        if !(self.config.has_look_alikes && self.gaze.is_search_turn) {
            self.find_candidates(input.percept, rng);
        }
        self.model.condition_on(input.percept);
        let novelty = self.novelty(input);
        let clearness = self.clearness(input, secs_of_camera);
        self.update_tracks(novelty, clearness);
        if says_something(self.model.as_ref()) {
            self.gaze.showed_something_at = Some(input.percept.at);
            (self.blind_secs, self.doubtful_secs) = (0.0, 0.0);
            self.update_reliability(input, novelty);
        } else if !self.does_another_see(input.percept.at) {
            self.go_blind();
        }
        self.update_estimate();
        self.doubt(secs);
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    fn camera_error_of(&self, camera_index: usize) -> Option<CameraMisalignment> {
        let mount = self.tracks.best_mount(camera_index).filter(|_| self.config.mount_pitch_rad > 0.0)?;
        Some(mount.camera_error(self.tracks.is_mount_known(camera_index, &self.config)))
    }

    fn individuals(&self, out: &mut Vec<Individual>) {
        self.search.individuals(out);
    }

    fn num_weighed(&self) -> usize {
        self.search.num_weighed()
    }
}
