//! A search for places of its own: poses that features of the image suggest, weighed by the observation model.

use nalgebra::Vector3;
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
                let likelihood = self.model.likelihood(&pose);
                if is_worth_keeping(&self.best, likelihood, effort.num_kept) && !is_known(&pose) {
                    let candidate = Candidate { world_from_robot: pose, tilt_rad: *tilt_rad };
                    keep(&mut self.best, candidate, likelihood, effort.num_kept);
                }
            }
        }
    }
}

/// Whether a pose of this likelihood is among the best `max`.
fn is_worth_keeping(best: &[(Candidate, f64)], likelihood: f64, max: usize) -> bool {
    best.len() < max || best.last().is_some_and(|last| last.1 < likelihood)
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
