//! A search for places of its own: poses that features of the image suggest, weighed by the observation model.

use nalgebra::Vector3;
use rand::RngExt;
use visloc_core::{
    Rng, RngTree,
    geom::{PlanarPose, weighted_pose_statistics},
};

use crate::{
    ObservationModel, Region,
    observation::features::{CameraState, FeatureModel},
    vision::Percept,
};

/// Two candidates nearer than this are one: the fit of either ends at the same place.
const SAME_PLACE_M: f64 = 0.15;
const SAME_PLACE_RAD: f64 = 0.1;

/// Places of which the middle is taken.
const MIDDLE_PLACES: u64 = 500;

/// The place with the least expected squared distance from a robot that may be anywhere on the map.
pub(super) fn middle(model: &dyn ObservationModel) -> PlanarPose {
    let mut rng = RngTree::new(1).stream("middle of the map", 0);
    let places: Vec<PlanarPose> = (0..MIDDLE_PLACES).map(|_| model.sample(&mut rng)).collect();
    let mean = weighted_pose_statistics(places.iter().map(|place| (*place, 1.0)))
        .map(|s| s.mean)
        .unwrap_or_default();
    let nearest = places.iter().min_by(|a, b| a.distance_m(&mean).total_cmp(&b.distance_m(&mean)));
    nearest.map_or(mean, |place| PlanarPose { yaw_rad: 0.0, ..*place })
}

/// A place at which a track may begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub world_from_robot: PlanarPose,
    /// Error of the camera's direction with which it was found: a rotation vector in the camera frame, radians.
    pub tilt_rad: Vector3<f64>,
}

/// How thoroughly one image is searched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Suggested poses that are weighed.
    pub num_poses: usize,
    /// Most of them that are kept.
    pub num_kept: usize,
}

/// Suggests places at which a track may begin.
pub(super) struct PlaceSearch {
    model: Box<dyn ObservationModel>,
    /// The most likely poses of the last search with their likelihood, the best first.
    best: Vec<(Candidate, f64)>,
}

impl PlaceSearch {
    pub fn new(model: Box<dyn ObservationModel>) -> Self {
        Self { model, best: Vec::new() }
    }

    /// Where the robot can be.
    pub fn region(&self) -> Region {
        self.model.region()
    }

    /// Forgets what was found.
    pub fn begin(&mut self) {
        self.best.clear();
    }

    /// What was found since the beginning, the most likely place first.
    pub fn found(&self) -> impl Iterator<Item = Candidate> + '_ {
        self.best.iter().map(|(candidate, _)| *candidate)
    }

    /// Keeps those of the found places at which most borders of the image lie near counterparts: a place beside the true one, from which a fit
    /// gets there, is not among the best of twenty pixels. The features must be those of the image as it was taken.
    pub fn keep_best_matched(&mut self, features: &dyn FeatureModel, gate_px: f64, num_kept: usize) {
        for (Candidate { world_from_robot, tilt_rad }, value) in &mut self.best {
            let state = CameraState { tilt_rad: *tilt_rad, ..CameraState::reported(*world_from_robot) };
            *value = 0.0;
            features.visit_matches(&state, gate_px, 1, &mut |feature| {
                let matched =
                    feature.residual.map_or(0.0, |residual| 1.0 - residual.error_px.abs() / gate_px);
                *value += matched.max(feature.unmatched_agreement);
            });
        }
        self.best.sort_by(|a, b| b.1.total_cmp(&a.1));
        self.best.truncate(num_kept);
    }

    /// Weighs suggestions for an image that is seen with the camera turned by `tilt_rad`, and keeps the most likely of those that are not
    /// known yet.
    pub fn search(
        &mut self,
        (percept, tilt_rad): (&Percept, &Vector3<f64>),
        features: &dyn FeatureModel,
        effort: Effort,
        is_known: impl Fn(&PlanarPose) -> bool,
        rng: &mut Rng,
    ) {
        self.model.condition_on(percept);
        if !self.model.has_evidence() {
            return;
        }
        let region = self.model.region();
        for _ in 0..effort.num_poses {
            let suggested = if rng.random_bool(0.5) { features.suggest(rng) } else { None };
            let pose = suggested.unwrap_or_else(|| self.model.propose(rng));
            if region.contains(&pose) {
                let least = to_beat(&self.best, effort.num_kept);
                if let Some(likelihood) = self.model.likelihood_above(&pose, least)
                    && !is_known(&pose)
                {
                    let candidate = Candidate { world_from_robot: pose, tilt_rad: *tilt_rad };
                    keep(&mut self.best, candidate, likelihood, effort.num_kept);
                }
            }
        }
    }
}

/// The likelihood above which a pose is among the best `max`.
fn to_beat(best: &[(Candidate, f64)], max: usize) -> f64 {
    if best.len() < max { f64::NEG_INFINITY } else { best.last().map_or(f64::INFINITY, |last| last.1) }
}

/// Keeps the best `max`, one for each place.
fn keep(best: &mut Vec<(Candidate, f64)>, candidate: Candidate, likelihood: f64, max: usize) {
    let pose = candidate.world_from_robot;
    let is_same = |other: &PlanarPose| {
        other.distance_m(&pose) < SAME_PLACE_M && other.heading_difference_rad(&pose) < SAME_PLACE_RAD
    };
    if let Some(i) = best.iter().position(|(other, _)| is_same(&other.world_from_robot)) {
        if best[i].1 >= likelihood {
            return;
        }
        best.remove(i);
    }
    let at = best.partition_point(|other| other.1 >= likelihood);
    best.insert(at, (candidate, likelihood));
    best.truncate(max);
}

#[cfg(test)]
mod tests {
    use visloc_world::Map;

    use super::*;
    use crate::observation::{
        features::{CameraVector, FeatureMatch, Residual},
        field::{FieldModelConfig, FieldObservationModel},
    };

    /// Features that lie 100 pixels per meter off counterparts that are seen from the origin with the camera turned by 0.02 rad.
    struct AtOrigin;

    impl FeatureModel for AtOrigin {
        fn condition_on(&mut self, _: &Percept) {}

        fn num_features(&self) -> usize {
            20
        }

        fn visit_matches(
            &self,
            state: &CameraState,
            gate_px: f64,
            _: usize,
            visit: &mut dyn FnMut(FeatureMatch),
        ) {
            let off_m = state.world_from_robot.x_m + state.tilt_rad.x - 0.02;
            let residual = Residual { error_px: 100.0 * off_m, jacobian: CameraVector::zeros() };
            let residual = (residual.error_px.abs() < gate_px).then_some(residual);
            for _ in 0..self.num_features() {
                visit(FeatureMatch { group: 0, residual, unmatched_agreement: 0.0, on_bar: None });
            }
        }
    }

    #[test]
    fn of_the_likely_places_those_stay_at_which_the_borders_match() {
        let candidate = |x_m: f64, tilt: f64| Candidate {
            world_from_robot: PlanarPose::new(x_m, 0.0, 0.0),
            tilt_rad: Vector3::new(tilt, 0.0, 0.0),
        };
        let best = [(2.0, 0.02), (1.0, 0.02), (0.2, 0.0), (0.1, 0.02)];
        let best = best
            .into_iter()
            .zip([0.9, 0.8, 0.7, 0.6])
            .map(|((x_m, tilt), likelihood)| (candidate(x_m, tilt), likelihood));
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2010") else { panic!("built-in map") };
        let model = FieldObservationModel::new(&field, &FieldModelConfig::default()).unwrap();
        let mut search = PlaceSearch { model: Box::new(model), best: best.collect() };
        search.keep_best_matched(&AtOrigin, 40.0, 2);
        let found: Vec<_> = search.found().collect();
        assert_eq!(found, [candidate(0.1, 0.02), candidate(0.2, 0.0)]);
    }
}
