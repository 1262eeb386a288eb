//! A search for places of its own: poses that features of the image suggest, weighed by the observation model.

use rand::RngExt;
use visloc_core::{
    Rng, RngTree,
    geom::{PlanarPose, weighted_pose_statistics},
};

use crate::{ObservationModel, Region, observation::features::FeatureModel, vision::Percept};

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

/// Suggests places at which a track may begin.
pub(super) struct PlaceSearch {
    model: Box<dyn ObservationModel>,
    /// The most likely poses of the last search with their likelihood, the best first.
    best: Vec<(PlanarPose, f64)>,
}

impl PlaceSearch {
    pub fn new(model: Box<dyn ObservationModel>) -> Self {
        Self { model, best: Vec::new() }
    }

    /// Where the robot can be.
    pub fn region(&self) -> Region {
        self.model.region()
    }

    /// Weighs `num_poses` suggestions and returns the most likely `num_kept` of those that are not known yet.
    pub fn search(
        &mut self,
        percept: &Percept,
        features: &dyn FeatureModel,
        (num_poses, num_kept): (usize, usize),
        is_known: impl Fn(&PlanarPose) -> bool,
        rng: &mut Rng,
    ) -> impl Iterator<Item = PlanarPose> + '_ {
        self.best.clear();
        self.model.condition_on(percept);
        if self.model.has_evidence() {
            let region = self.model.region();
            for _ in 0..num_poses {
                let suggested = if rng.random_bool(0.5) { features.suggest(rng) } else { None };
                let pose = suggested.unwrap_or_else(|| self.model.propose(rng));
                if region.contains(&pose) {
                    let likelihood = self.model.likelihood(&pose);
                    if is_worth_keeping(&self.best, likelihood, num_kept) && !is_known(&pose) {
                        keep(&mut self.best, pose, likelihood, num_kept);
                    }
                }
            }
        }
        self.best.iter().map(|(pose, _)| *pose)
    }
}

/// Whether a pose of this likelihood is among the best `max`.
fn is_worth_keeping(best: &[(PlanarPose, f64)], likelihood: f64, max: usize) -> bool {
    best.len() < max || best.last().is_some_and(|last| last.1 < likelihood)
}

/// Keeps the best `max`, one for each place.
fn keep(best: &mut Vec<(PlanarPose, f64)>, pose: PlanarPose, likelihood: f64, max: usize) {
    let is_same = |other: &PlanarPose| {
        other.distance_m(&pose) < SAME_PLACE_M && other.heading_difference_rad(&pose) < SAME_PLACE_RAD
    };
    if let Some(i) = best.iter().position(|(other, _)| is_same(other)) {
        if best[i].1 >= likelihood {
            return;
        }
        best.remove(i);
    }
    let at = best.partition_point(|other| other.1 >= likelihood);
    best.insert(at, (pose, likelihood));
    best.truncate(max);
}
