//! The tracks together: birth from the hypotheses of a localizer, competition, merging and death.

use visloc_geom::PlanarPose;

use super::{
    RefinementConfig,
    filter::{Agreement, PoseFilter},
    known::Known,
};
use crate::{Region, observation::features::FeatureModel};

/// Gates of a new track, from coarse to fine, pixels.
const BIRTH_GATES_PX: [f64; 5] = [40.0, 25.0, 15.0, 10.0, 8.0];
/// Fewer features than this say nothing.
const MIN_FEATURES: usize = 6;
/// Share of the newest image in the agreement of late.
const AGREEMENT_FOLLOW: f64 = 0.15;
/// What one image of landmarks that are all explained adds to the confirmation.
const CONFIRMATION: f64 = 0.1;
/// What one image of landmarks that are not explained takes away: less, since boards and clothes have colors of landmarks.
const CONTRADICTION: f64 = 0.02;
/// What a view that is all new adds on a map without landmarks, if it is explained this well.
const VIEW_CONFIRMATION: f64 = 0.04;
const GOOD_AGREEMENT: f64 = 0.8;
/// How far, as a logarithm of odds, a new track starts behind one that is fully confirmed: somebody must have carried the
/// robot away.
const ESTABLISHED_LOG_ODDS: f64 = 14.0;
/// So many features are full evidence.
const MANY_FEATURES: f64 = 30.0;
/// A track whose odds fall below the best one's by this is given up, as a logarithm.
const HOPELESS: f64 = 20.0;

/// One hypothesis with its filter.
#[derive(Debug, Clone)]
pub(super) struct Track {
    pub id: u64,
    pub filter: PoseFilter,
    /// Agreement of the last image.
    pub last_agreement: f64,
    /// Agreement of late.
    pub agreement: f64,
    /// How far landmarks, or new views on a map without any, have confirmed it, 0 to 1.
    pub confirmed: f64,
    /// Logarithm of its odds against the best one: 0 or less.
    pub log_odds: f64,
    /// On a symmetric map, the probability that the robot is here rather than at the mirrored pose; otherwise 1.
    pub own_share: f64,
    /// How far off the place where the prior held was when the prior was last asked, meters.
    asked_spread_m: f64,
}

impl Track {
    /// Landmarks in view confirm the track or take its confirmation away; without landmarks new views do, slowly.
    fn confirm(&mut self, agreement: &Agreement, view: &View) {
        if !view.has_landmarks {
            let step =
                if agreement.value() > GOOD_AGREEMENT { VIEW_CONFIRMATION } else { -VIEW_CONFIRMATION };
            self.confirmed = (self.confirmed + step * view.novelty).clamp(0.0, 1.0);
        } else if let Some(share) = agreement.of_landmarks() {
            let step = if share > 0.0 { CONFIRMATION } else { CONTRADICTION };
            self.confirmed = (self.confirmed + step * share).clamp(0.0, 1.0);
        }
    }

    /// Takes the more probable one of two mirrored poses. `share` is the probability of the present one.
    fn share(&mut self, share: f64, model: &dyn FeatureModel) {
        self.own_share = share;
        if share < 0.5
            && let Some(mirrored) = model.mirrored(&self.filter.pose())
        {
            self.filter.set_pose(&mirrored);
            self.own_share = 1.0 - share;
        }
    }

    /// Asks the prior again while the pose gets better: a first guess beside the line that parts two halves may be on the
    /// wrong side of it.
    fn ask(&mut self, known: &Known, model: &dyn FeatureModel) {
        let spread_m = known.spread_m(self.filter.spread_m());
        if spread_m < self.asked_spread_m
            && let Some(share) = known.share_by_prior(model, &self.filter.pose())
        {
            self.asked_spread_m = spread_m;
            self.share(share, model);
        }
    }
}

/// What the tracks have to know about an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// How much of it is new, 0 to 1.
    pub novelty: f64,
    /// Whether the map has landmarks.
    pub has_landmarks: bool,
}

/// All tracks; the best one comes first.
#[derive(Debug, Clone, Default)]
pub(super) struct Tracks {
    tracks: Vec<Track>,
    next_id: u64,
}

impl Tracks {
    pub fn clear(&mut self) {
        self.tracks.clear();
    }

    pub fn best(&self) -> Option<&Track> {
        self.tracks.first()
    }

    pub fn iter(&self) -> impl Iterator<Item = &Track> {
        self.tracks.iter()
    }

    pub fn predict(&mut self, odometry: Option<&PlanarPose>, secs: f64, config: &RefinementConfig) {
        for track in &mut self.tracks {
            track.filter.predict(odometry, secs, config);
        }
    }

    /// Takes in the features of an image, and places where tracks may begin. What is known chooses between a pose and its
    /// mirrored one.
    pub fn update(
        &mut self,
        model: &dyn FeatureModel,
        places: &[PlanarPose],
        view: &View,
        known: &Known,
        config: &RefinementConfig,
    ) {
        if model.num_features() < MIN_FEATURES {
            return;
        }
        #[allow(clippy::cast_precision_loss)]
        let weight = config.evidence_per_image * (model.num_features() as f64 / MANY_FEATURES).min(1.0);
        for track in &mut self.tracks {
            // The less is known the wider the first gate.
            let wide =
                BIRTH_GATES_PX.partition_point(|gate| *gate > track.filter.spread_px() + config.gate_px);
            let gates = &BIRTH_GATES_PX[wide.min(BIRTH_GATES_PX.len() - 2)..];
            let agreement = track.filter.update(model, gates, config);
            track.confirm(&agreement, view);
            track.last_agreement = agreement.value();
            track.agreement += AGREEMENT_FOLLOW * (track.last_agreement - track.agreement);
            track.log_odds += weight * track.last_agreement;
            track.ask(known, model);
        }
        self.rank();
        let handicap = self.best().map_or(0.0, |best| ESTABLISHED_LOG_ODDS * best.confirmed);
        for place in places {
            self.bear(model, place, handicap, known, config);
        }
        self.rank();
        self.merge(model, config);
        self.tracks.retain(|track| track.log_odds > -HOPELESS && track.agreement > config.lost_agreement);
        self.tracks.truncate(config.max_tracks);
    }

    /// The best one first, with odds of 1.
    fn rank(&mut self) {
        // Stable: of equals the older one stays in front.
        self.tracks.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
        let best = self.tracks.first().map_or(0.0, |track| track.log_odds);
        for track in &mut self.tracks {
            track.log_odds -= best;
        }
    }

    /// Begins a track at a place that no track follows, if it explains the features.
    fn bear(
        &mut self,
        model: &dyn FeatureModel,
        place: &PlanarPose,
        handicap: f64,
        known: &Known,
        config: &RefinementConfig,
    ) {
        if knows(&self.tracks, model, place, 1.5, config) {
            return;
        }
        let mut filter = match self.tracks.first() {
            Some(track) => track.filter.moved_to(place, config),
            None => PoseFilter::new(place, config),
        };
        let agreement = filter.update(model, &BIRTH_GATES_PX, config).value();
        let best = self.tracks.first().map_or(0.0, |track| track.agreement);
        if agreement < config.min_birth_agreement.max(best - 0.2)
            || knows(&self.tracks, model, &filter.pose(), 1.0, config)
        {
            return;
        }
        let mut track = Track {
            id: self.next_id,
            asked_spread_m: known.spread_m(filter.spread_m()),
            own_share: 1.0,
            filter,
            last_agreement: agreement,
            agreement,
            confirmed: 0.0,
            log_odds: -handicap,
        };
        track.share(known.share(model, &track.filter.pose()), model);
        self.tracks.push(track);
        self.next_id += 1;
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
            if knows(&self.tracks[..i], model, &pose, 1.0, config) {
                self.tracks.remove(i);
            } else {
                i += 1;
            }
        }
    }
}

/// Whether one of the tracks is at this place or its mirrored one, or at some times the distance.
fn knows(
    tracks: &[Track],
    model: &dyn FeatureModel,
    place: &PlanarPose,
    factor: f64,
    config: &RefinementConfig,
) -> bool {
    let mirrored = model.mirrored(place);
    tracks.iter().any(|track| {
        let pose = track.filter.pose();
        is_near(&pose, place, factor, config)
            || mirrored.is_some_and(|place| is_near(&pose, &place, factor, config))
    })
}

fn is_near(a: &PlanarPose, b: &PlanarPose, factor: f64, config: &RefinementConfig) -> bool {
    a.distance_m(b) < factor * config.merge_distance_m
        && a.heading_difference_rad(b) < factor * config.merge_turn_rad
}
