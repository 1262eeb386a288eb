//! Where tracks begin: at places that a search has come to and that no track follows.

use visloc_core::geom::PlanarPose;

use super::{BIRTH_GATES_PX, ESTABLISHED_LOG_ODDS, Tracks};
use crate::{
    observation::features::FeatureModel,
    per_camera::OtherCameras,
    refine::{
        RefinementConfig,
        evidence::log_evidence,
        filter::PoseFilter,
        known::Known,
        place::{is_same, near},
        search::Candidate,
        track::{FoundFit, Track},
        view::{View, ViewEvidence},
    },
};

/// Where places look alike, finding all of them takes a while: this much of a lead over a place that was found later says nothing, as a
/// logarithm of odds.
const MAX_LATE: f64 = 3.0;
/// A track that explains the images worse than the best one by more than this does not keep others from its place.
const BLOCKING_DEFICIT: f64 = 0.1;

impl Tracks {
    /// By how much a new track starts behind the best one, as a logarithm of odds: a place that explains the earlier views as well would have
    /// been found in them as often, or somebody has carried the robot. Landmarks that the best one explains speak against its twin.
    fn handicap(&self, model: &dyn FeatureModel, place: &PlanarPose, config: &RefinementConfig) -> f64 {
        self.best().map_or(0.0, |best| {
            if config.has_look_alikes {
                ESTABLISHED_LOG_ODDS * best.confirmed
            } else {
                let is_twin =
                    model.twin(&best.filter.pose()).is_some_and(|twin| is_same(&twin, place, 1.0, config));
                let by_landmarks = if is_twin { best.told_by_landmarks() } else { 0.0 };
                best.past_found.max(by_landmarks).min(ESTABLISHED_LOG_ODDS)
            }
        })
    }

    /// The place that only landmarks tell from the best track's: nobody has to search for it.
    pub(super) fn twin(&self, model: &dyn FeatureModel) -> Option<Candidate> {
        let best = self.best()?;
        let world_from_robot = model.twin(&best.filter.pose())?;
        Some(Candidate { world_from_robot, tilt_rad: best.filter.mount().tilt_rad })
    }

    /// Whether a track follows this place already. One that explains it badly may have got stuck beside it.
    pub fn know(&self, model: &dyn FeatureModel, place: &PlanarPose, config: &RefinementConfig) -> bool {
        let good = |track: &Track| !(config.has_look_alikes && track.deficit > BLOCKING_DEFICIT);
        near(&self.tracks, model, place, 1.5, config).any(|i| good(&self.tracks[i]))
    }

    /// Begins a track at a place that no track follows, if it explains the features.
    pub(super) fn bear(
        &mut self,
        model: &dyn FeatureModel,
        candidate: &Candidate,
        view: &View,
        known: &Known,
        config: &RefinementConfig,
    ) {
        let place = &candidate.world_from_robot;
        if self.know(model, place, config) && (config.has_look_alikes || view.is_localized) {
            return;
        }
        let mut filter = match &self.robot.filter {
            Some(known) => known.moved_to(place, &self.robot.mount, config),
            None => PoseFilter::new(place, &self.robot.mount, config),
        };
        let fitted = filter.update_from(&candidate.tilt_rad, model, &BIRTH_GATES_PX, config);
        let agreement = fitted.agreement.value();
        let last_told = log_evidence(model, &fitted, &view.region, config);
        let even = *self.even.get_or_insert((&last_told).into());
        let of_image = ViewEvidence::found(&last_told, &even);
        let of_view = self.best().map_or(of_image, |best| of_image.after(&best.view_evidence));
        let best_fitted = self.tracks.first().map_or(agreement, |track| track.last_agreement);
        let best = self.tracks.first().map_or(0.0, |track| track.agreement);
        if agreement < config.min_birth_agreement.max(best - 0.2) {
            return;
        }
        let deficit = (best_fitted - agreement).max(0.0);
        let bend = self.robot.bend(&filter, config);
        let best_bend = self.tracks.first().map_or(bend, |track| track.bend);
        let handicap = self.handicap(model, &filter.pose(), config);
        let (log_odds, past_log_odds) = if config.has_look_alikes {
            (-handicap - (bend - best_bend).max(0.0), 0.0)
        } else {
            // It could have been there all the time, as well as the best one, if nobody has carried the robot.
            let past = self.best().map_or(0.0, |best| best.past_log_odds) - handicap;
            let others = self.best().map_or(0.0, Track::other_log_odds);
            (past + of_view.log_odds() + others - bend, past)
        };
        let found_again = near(&self.tracks, model, &filter.pose(), 1.0, config).next();
        if let Some(i) = found_again {
            let stuck = &mut self.tracks[i];
            let found =
                FoundFit { filter, told: last_told, agreement, deficit, bend, log_odds, of_image, of_view };
            if !config.has_look_alikes {
                stuck.find_again(found, model);
            } else if i > 0 && stuck.deficit - deficit > BLOCKING_DEFICIT {
                stuck.correct(found);
                stuck.fitted_in = self.turn;
            }
            return;
        }
        let mut track = Track {
            id: self.next_id,
            asked_spread_m: known.spread_m(filter.spread_m()),
            own_share: 1.0,
            filter,
            last_agreement: agreement,
            deficit,
            fitted_in: self.turn,
            agreement,
            confirmed: 0.0,
            seen_doors: 0.0,
            log_odds,
            past_log_odds,
            last_told,
            past_landmarks: 0.0,
            past_found: 0.0,
            bend,
            view_evidence: of_view,
            other_views: self.best().map_or_else(OtherCameras::none, Track::expected_other_views),
            late: if config.has_look_alikes { handicap.min(MAX_LATE) } else { 0.0 },
        };
        let share = known.share(model, &track.filter.pose(), track.filter.spread_m());
        track.share(share, model);
        self.tracks.push(track);
        self.next_id += 1;
    }

    /// A search of the whole map has come to these places.
    pub fn found(&mut self, places: &[Candidate], model: &dyn FeatureModel, config: &RefinementConfig) {
        for track in &mut self.tracks {
            let pose = track.filter.pose();
            let mirrored = model.mirrored(&pose);
            let is_there = |place: &Candidate| {
                let place = &place.world_from_robot;
                is_same(&pose, place, 1.5, config)
                    || mirrored.is_some_and(|pose| is_same(&pose, place, 1.5, config))
            };
            track.view_evidence.num_found += f64::from(u8::from(places.iter().any(is_there)));
        }
    }
}
