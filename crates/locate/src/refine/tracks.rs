//! The tracks together: birth from the hypotheses of a localizer, competition, merging and death.

mod birth;

use nalgebra::Matrix3;

use super::{
    RefinementConfig,
    evidence::log_evidence,
    filter::PoseFilter,
    known::Known,
    mount::Mount,
    place::near,
    robot::KnownRobot,
    search::Candidate,
    track::Track,
    view::{Even, View},
};
use crate::{Region, observation::features::FeatureModel, odometer::Odometry};

/// Gates of a new track, from coarse to fine, pixels.
pub(super) const BIRTH_GATES_PX: [f64; 5] = [40.0, 25.0, 15.0, 10.0, 8.0];
/// Fewer features than this say nothing.
const MIN_FEATURES: usize = 6;
/// Share of the newest image in the agreement of late.
const AGREEMENT_FOLLOW: f64 = 0.15;
/// How far, as a logarithm of odds, a new track starts behind the best one at most, one that is fully confirmed: somebody must have
/// carried the robot away.
const ESTABLISHED_LOG_ODDS: f64 = 14.0;
/// So many features are full evidence.
const MANY_FEATURES: f64 = 30.0;
/// Images after which a track's last one is not older for it.
const MAX_STALE: u64 = 1000;
/// A track whose odds are below the best one's by this has no say in the answer, as a logarithm.
const MIN_LOG_ODDS: f64 = 5.0;
/// Tracks that are compared with each other for the answer at most.
const MAX_ANSWERS: usize = 64;

/// All tracks; the best one comes first.
#[derive(Debug, Clone, Default)]
pub(super) struct Tracks {
    tracks: Vec<Track>,
    next_id: u64,
    /// Counts images, to let tracks take turns.
    turn: u64,
    /// The tracks that take turns: image that they were last fitted to, and name.
    waiting: Vec<(u64, u64)>,
    /// Logarithms of the marginal likelihood of the present image for a place whose view has odds of 1.
    even: Option<Even>,
    robot: KnownRobot,
}

impl Tracks {
    /// None yet, of a robot of which nothing is known.
    pub fn new(config: &RefinementConfig) -> Self {
        Self { robot: KnownRobot::unknown(config), ..Self::default() }
    }

    /// What is known of the camera wherever the robot is.
    pub fn mount(&self) -> &Mount {
        &self.robot.mount
    }

    /// Whether a camera is known much better than that of any robot.
    pub fn is_mount_known(&self, camera_index: usize, config: &RefinementConfig) -> bool {
        self.robot.mount_of(camera_index).is_some_and(|mount| mount.is_known(config))
    }

    /// What the best track has found out about the constant error of a camera; `None` if that has taken no image.
    pub fn best_mount(&self, camera_index: usize) -> Option<Mount> {
        let filter = &self.best()?.filter;
        if camera_index == self.robot.camera_index {
            return Some(filter.mount());
        }
        filter.other_mounts().find(|(index, _)| *index == camera_index).map(|(_, mount)| mount)
    }

    /// The next image is of this camera; see [`PoseFilter::look_through`].
    pub fn look_through(&mut self, camera_index: usize, turn: &Matrix3<f64>, config: &RefinementConfig) {
        let cameras = (self.robot.camera_index, camera_index);
        if cameras.0 == cameras.1 {
            return;
        }
        self.robot.look_through(camera_index, config);
        let mount = self.robot.mount;
        self.tracks.iter_mut().for_each(|track| track.look_through(cameras, turn, &mount));
        if let Some(filter) = &mut self.robot.filter {
            filter.look_through(cameras, turn, &mount);
        }
    }

    /// The robot has been lost for so long.
    pub fn doubt_mounts(&mut self, secs: f64, config: &RefinementConfig) {
        self.robot.doubt_mounts(secs, config);
    }

    pub fn clear(&mut self) {
        self.tracks.clear();
    }

    pub fn best(&self) -> Option<&Track> {
        self.tracks.first()
    }

    pub fn iter(&self) -> impl Iterator<Item = &Track> {
        self.tracks.iter()
    }

    fn filters(&mut self) -> impl Iterator<Item = &mut PoseFilter> {
        self.tracks.iter_mut().map(|track| &mut track.filter).chain(&mut self.robot.filter)
    }

    pub fn predict(&mut self, odometry: &Odometry, secs: f64, config: &RefinementConfig) {
        self.filters().for_each(|filter| filter.predict(odometry, secs, config));
    }

    /// Images have shown nothing for `from_secs` until the last one, and for `to_secs` until now.
    pub fn drift(&mut self, from_secs: f64, to_secs: f64, config: &RefinementConfig) {
        self.filters().for_each(|filter| filter.drift(from_secs, to_secs, config));
    }

    /// Takes in the features of an image, and places where tracks may begin. What is known chooses between a pose and its
    /// mirrored one.
    pub fn update(
        &mut self,
        model: &dyn FeatureModel,
        places: &[Candidate],
        view: &View,
        known: &Known,
        config: &RefinementConfig,
    ) {
        if !says_something(model) {
            return;
        }
        let weight = config.evidence_per_image * fullness(model) * view.clearness;
        self.tracks.iter_mut().for_each(|track| track.move_on(view.novelty));
        self.fit(model, view, known, config);
        self.even = self.weigh_image();
        if config.has_look_alikes {
            self.compete(weight, config);
        } else {
            self.weigh(config);
        }
        self.rank();
        for place in places {
            self.bear(model, place, view, known, config);
        }
        if !view.is_localized
            && let Some(twin) = self.twin(model)
            && !self.know(model, &twin.world_from_robot, config)
        {
            self.bear(model, &twin, view, known, config);
        }
        self.rank();
        self.merge(model, config);
        self.tracks
            .retain(|track| track.log_odds > -config.hopeless && track.agreement > config.lost_agreement);
        self.tracks.truncate(config.max_tracks);
    }

    /// Fits the tracks to an image: the best ones, and of the others those whose turn it is.
    fn fit(&mut self, model: &dyn FeatureModel, view: &View, known: &Known, config: &RefinementConfig) {
        let num_first = config.max_fits.div_ceil(2);
        let num_others = self.tracks.len().saturating_sub(num_first);
        let num_fits = config.max_fits.saturating_sub(num_first).max(1);
        let is_crowded = self.tracks.len() > config.max_fits;
        let rounds = if is_crowded { num_others.div_ceil(num_fits) as u64 } else { 1 };
        self.turn = self.turn.wrapping_add(1);
        // With many tracks, whose number changes from image to image, some would wait for very long in fixed rounds.
        let last_in_line =
            (is_crowded && config.has_look_alikes).then(|| self.last_in_line(num_first, num_fits));
        let turn = self.turn;
        let waits = |track: &Track| match last_in_line {
            Some(last) => (track.fitted_in, track.id) > last,
            None => !(track.id + turn).is_multiple_of(rounds),
        };
        // Where doors tell the place, a thing on the floor may be all that an image shows.
        let follow = AGREEMENT_FOLLOW * if config.has_look_alikes { fullness(model) } else { 1.0 };
        for (i, track) in self.tracks.iter_mut().enumerate() {
            if i >= num_first && waits(track) {
                continue;
            }
            // The less is known the wider the first gate.
            let wide =
                BIRTH_GATES_PX.partition_point(|gate| *gate > track.filter.spread_px() + config.gate_px);
            let gates = &BIRTH_GATES_PX[wide.min(BIRTH_GATES_PX.len() - 2)..];
            let fitted = track.filter.update(model, gates, config);
            let agreement = fitted.agreement;
            track.last_told = log_evidence(model, &fitted, &view.region, config);
            track.confirm(&agreement, view);
            track.fitted_in = self.turn;
            track.last_agreement = agreement.value();
            track.agreement += follow * (track.last_agreement - track.agreement);
            track.ask(known, model);
        }
    }

    /// The last one of the `num_fits` tracks behind the first ones that have waited longest.
    fn last_in_line(&mut self, num_first: usize, num_fits: usize) -> (u64, u64) {
        self.waiting.clear();
        self.waiting.extend(self.tracks[num_first..].iter().map(|track| (track.fitted_in, track.id)));
        *self.waiting.select_nth_unstable(num_fits - 1).1
    }

    /// Odds of the tracks: what the present view tells and what was known before.
    fn weigh(&mut self, config: &RefinementConfig) {
        for track in &mut self.tracks {
            if let Some(even) = &self.even
                && track.fitted_in == self.turn
            {
                track.view_evidence.add(&track.last_told, even);
            }
            track.bend = self.robot.bend(&track.filter, config);
            track.weigh();
        }
    }

    /// What this image is to a place whose view has odds of 1, so that evidence of different images is told from what one shows more than the
    /// other: the expectation over which track is right by all that is known with this image, where tracks that are known from more images of the
    /// view tell it better. A place that the image speaks against tells nothing of it.
    fn weigh_image(&self) -> Option<Even> {
        let mean = |part: fn(&Track) -> (f64, f64)| {
            let fitted = || self.tracks.iter().filter(|track| track.fitted_in == self.turn);
            let highest = fitted().map(|track| part(track).0).reduce(f64::max)?;
            let (mut sum, mut total) = (0.0, 0.0);
            for track in fitted() {
                let (evenness, num_before) = part(track);
                let num_images = 1.0 + num_before;
                let told = (evenness - highest) / num_images;
                let weight = num_images * (track.log_odds + told).exp();
                sum += weight * evenness;
                total += weight;
            }
            (total > 0.0).then(|| sum / total)
        };
        let by_lines = mean(|track| (track.evenness().by_lines, track.view_evidence.lines.num_images))?;
        let by_landmarks =
            mean(|track| (track.evenness().by_landmarks, track.view_evidence.landmarks.num_images))?;
        Some(Even { by_lines, by_landmarks })
    }

    /// Where places look alike, counts an image as evidence: who explains it worse than the best one loses odds. A track whose turn it was not is taken to
    /// fall behind the best one as in its last image, but ever less: that image may have been a bad one. Agreements of different
    /// images are not compared: a hard image would speak against all that were fitted to it.
    fn compete(&mut self, weight: f64, config: &RefinementConfig) {
        let fitted = self.tracks.iter().filter(|track| track.fitted_in == self.turn);
        let best = fitted.map(|track| track.last_agreement).fold(0.0, f64::max);
        for track in &mut self.tracks {
            if track.fitted_in == self.turn {
                track.deficit = best - track.last_agreement;
            }
            let worse = track.deficit.min(config.max_evidence_difference);
            let lost = (worse - config.evidence_deadband).max(0.0);
            let images_since = self.turn.saturating_sub(track.fitted_in).min(MAX_STALE);
            let still_true = config.stale_evidence_kept.powi(images_since as i32);
            track.log_odds = config.evidence_kept * track.log_odds - weight * still_true * lost;
            track.late *= config.evidence_kept;
            if track.fitted_in == self.turn {
                track.set_bend(self.robot.bend(&track.filter, config));
            }
        }
    }

    /// The best track is right: what it has found out about the robot is kept when all tracks are given up.
    pub fn remember_robot(&mut self) {
        let Some(best) = self.tracks.first() else { return };
        self.robot.remember(&best.filter);
    }

    /// Sum of the odds of all tracks against the best one, with the lead given back to the others that it owes to its camera alone or
    /// to having been found a little earlier: nothing to rely on.
    pub fn total_odds(&self, has_landmarks: bool, config: &RefinementConfig) -> f64 {
        let Some(best) = self.best() else { return 1.0 };
        if !config.has_look_alikes {
            // Where only landmarks tell a place from its twin nothing else speaks against that, however well lines fit.
            let twin = if has_landmarks { (-ESTABLISHED_LOG_ODDS * best.confirmed).exp() } else { 0.0 };
            return twin + self.tracks.iter().map(|track| track.log_odds.exp()).sum::<f64>();
        }
        let unearned = |track: &Track| (track.bend - best.bend).max(0.0) + (track.late - best.late).max(0.0);
        self.tracks.iter().map(|track| (track.log_odds + unearned(track)).min(0.0).exp()).sum()
    }

    /// The track whose place has the least expected distance from where the robot is. As soon as the most probable one has half of
    /// the odds it is that.
    pub fn least_error(&self) -> Option<&Track> {
        let odds = |track: &Track| track.log_odds.exp();
        let total: f64 = self.tracks.iter().map(odds).sum();
        let best = self.best()?;
        if odds(best) >= 0.5 * total {
            return Some(best);
        }
        let probable = || self.tracks.iter().take(MAX_ANSWERS).filter(|track| track.log_odds > -MIN_LOG_ODDS);
        let expected_m = |track: &Track| -> f64 {
            let place = track.filter.pose();
            probable().map(|other| odds(other) * other.filter.pose().distance_m(&place)).sum()
        };
        probable()
            .map(|track| (track, expected_m(track)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(track, _)| track)
    }

    /// The best one first, with odds of 1.
    fn rank(&mut self) {
        // Stable: of equals the older one stays in front.
        self.tracks.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
        let best = self.tracks.first().map_or(0.0, |track| track.log_odds);
        for track in &mut self.tracks {
            track.log_odds -= best;
            track.past_log_odds -= best;
        }
    }

    /// Gives up the tracks that have left the map.
    pub fn leave(&mut self, region: &Region) {
        self.tracks.retain(|track| region.contains(&track.filter.pose()));
        self.rank();
    }

    /// Of two tracks at one place, or at mirrored ones, the one with more evidence stays.
    fn merge(&mut self, model: &dyn FeatureModel, config: &RefinementConfig) {
        let mut i = 1;
        while i < self.tracks.len() {
            let pose = self.tracks[i].filter.pose();
            if near(&self.tracks[..i], model, &pose, 1.0, config).next().is_some() {
                self.tracks.remove(i);
            } else {
                i += 1;
            }
        }
    }
}

/// Whether an image has enough features to say anything.
pub(super) fn says_something(model: &dyn FeatureModel) -> bool {
    model.num_features() >= MIN_FEATURES
}

/// How much an image has to say, 0 to 1.
pub(super) fn fullness(model: &dyn FeatureModel) -> f64 {
    (model.num_features() as f64 / MANY_FEATURES).min(1.0)
}
