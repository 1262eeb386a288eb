//! Bundle adjustment of a part of the map.

use nalgebra::Vector2;

use crate::{
    config::MappingConfig,
    lie::CameraFromWorld,
    map::{Crossing, KeyframeId, LandmarkId, Map},
    odometry::{OdomPose, SURE_WAY_M, motion_deviations},
    solve::{Bundle, BundleMotion, BundleObservation, BundleSettings, BundleTie},
    track::{focal_px, whitening},
};

/// 95 % limit of chi-square with two degrees of freedom.
pub(crate) const CHI2: f64 = 5.991;

/// How an adjustment went.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AdjustReport {
    /// Keyframes that could move.
    pub num_free: usize,
    /// Landmarks that could move.
    pub num_points: usize,
    /// Observations dropped as outliers.
    pub num_dropped: usize,
}

/// Which keyframe and landmark each index of a bundle is.
#[derive(Debug)]
pub(crate) struct Index {
    pub keyframes: Vec<KeyframeId>,
    pub landmarks: Vec<LandmarkId>,
}

/// Adjusts a keyframe, the keyframes most connected to it and their landmarks; other observers stay where they are.
pub fn adjust_local(
    map: &mut Map,
    newest: KeyframeId,
    config: &MappingConfig,
    focal_px: f64,
) -> AdjustReport {
    let mut free = vec![newest];
    let connected = map.connected(newest, 10).into_iter().map(|(id, _)| id).take(config.bundle_keyframes - 1);
    free.extend(connected.filter(|id| !map.is_fixed(*id)));
    adjust(map, collect(map, &free, focal_px), config)
}

/// Adjusts all keyframes and landmarks but the first keyframe.
pub fn adjust_all(map: &mut Map, config: &MappingConfig, focal_px: f64) -> AdjustReport {
    let free: Vec<KeyframeId> = map.free_keyframes().map(|(id, _)| id).collect();
    adjust(map, collect(map, &free, focal_px), config)
}

/// As [`adjust_all`], for a map that has been adjusted all along: what neighbors have moved between each other is known. Their views err alike, which
/// no covariance tells, so that the way would break where least of it is known, as where the camera was lost.
pub fn adjust_way(map: &mut Map, config: &MappingConfig, focal_px: f64) -> AdjustReport {
    let free: Vec<KeyframeId> = map.free_keyframes().map(|(id, _)| id).collect();
    let (mut bundle, index) = collect(map, &free, focal_px);
    for (i, pair) in bundle.cameras[..free.len()].windows(2).enumerate() {
        let depth = map.depth_of(free[i]).unwrap_or(1.0);
        bundle.motions.push(BundleMotion {
            cameras: (i, i + 1),
            second_from_first: pair[1] * pair[0].inverse(),
            deviations: (2.0 * NEIGHBOR_SIGMA * depth, 0.5 * NEIGHBOR_SIGMA),
        });
    }
    adjust(map, (bundle, index), config)
}

/// Adjusts a copy of a whole map step by step, while the map goes on.
#[derive(Debug)]
pub struct WholeAdjustment {
    bundle: Bundle,
    index: Index,
    last_cost: Option<f64>,
}

/// Keyframes of a map from which on it is too large to be adjusted as a whole: time and memory of a step grow with their square.
pub(crate) const MOST_KEYFRAMES: usize = 200;
/// Gain of a step, share of the cost, below which more steps are of no use.
const LEAST_GAIN: f64 = 1e-5;

impl WholeAdjustment {
    /// Of these keyframes, in order, and all that they see.
    #[must_use]
    pub fn new(map: &Map, free: &[KeyframeId], focal_px: f64) -> Self {
        let (bundle, index) = collect(map, free, focal_px);
        Self { bundle, index, last_cost: None }
    }

    /// Does some iterations; says whether more may help. Outliers are left out from the second time on.
    pub fn step(&mut self) -> bool {
        if self.last_cost.is_some() {
            let mut observations = std::mem::take(&mut self.bundle.observations);
            let squared_error = |o: &BundleObservation| Some(self.bundle.residual(o)?.norm_squared());
            observations.retain(|o| squared_error(o).is_some_and(|error| error <= 4.0 * CHI2));
            self.bundle.observations = observations;
        }
        let settings = BundleSettings { max_iterations: 1, huber: CHI2.sqrt() };
        let report = self.bundle.solve(&settings);
        let gain = (report.first_cost - report.last_cost) / report.first_cost.max(1e-300);
        let is_first = self.last_cost.replace(report.last_cost).is_none();
        is_first || gain > LEAST_GAIN
    }

    /// The keyframes and their new poses, in order.
    #[must_use]
    pub fn keyframes(&self) -> Vec<(KeyframeId, CameraFromWorld)> {
        let mut poses: Vec<(KeyframeId, CameraFromWorld)> =
            self.index.keyframes.iter().copied().zip(self.bundle.cameras.iter().copied()).collect();
        poses.sort_unstable_by_key(|(id, _)| *id);
        poses
    }

    /// Moves the landmarks that are still there.
    pub fn move_landmarks(&self, map: &mut Map) {
        for (id, point) in self.index.landmarks.iter().zip(&self.bundle.points) {
            if map.landmark(*id).is_converged() {
                map.landmark_mut(*id).point_in_world = *point;
            }
        }
    }
}

fn adjust(map: &mut Map, (mut bundle, index): (Bundle, Index), config: &MappingConfig) -> AdjustReport {
    let settings = |max_iterations| BundleSettings { max_iterations, huber: CHI2.sqrt() };
    bundle.solve(&settings(config.bundle_first_iterations));
    let is_outlier = |bundle: &Bundle, o: &BundleObservation| {
        bundle.residual(o).is_none_or(|error| error.norm_squared() > CHI2)
    };
    let mut observations = std::mem::take(&mut bundle.observations);
    let mut dropped: Vec<BundleObservation> = Vec::new();
    observations.retain(|observation| {
        let is_outlier = is_outlier(&bundle, observation);
        dropped.extend(is_outlier.then_some(*observation));
        !is_outlier
    });
    bundle.observations = observations;
    bundle.solve(&settings(config.bundle_last_iterations));
    take_over(map, &bundle, &index);
    let mut num_dropped = 0;
    for observation in &dropped {
        // A second chance: what was far off at first may fit in the end.
        if is_outlier(&bundle, observation) {
            num_dropped += 1;
            map.remove_observation(index.landmarks[observation.point], index.keyframes[observation.camera]);
        }
    }
    let num_free = bundle.is_free.iter().filter(|is_free| **is_free).count();
    AdjustReport { num_free, num_points: index.landmarks.len(), num_dropped }
}

/// Moves keyframes and landmarks to where a bundle has them.
pub(crate) fn take_over(map: &mut Map, bundle: &Bundle, index: &Index) {
    for (i, id) in index.keyframes.iter().enumerate().filter(|(i, _)| bundle.is_free[*i]) {
        map.set_pose(*id, bundle.cameras[i]);
    }
    for (id, point) in index.landmarks.iter().zip(&bundle.points) {
        map.landmark_mut(*id).point_in_world = *point;
    }
}

pub(crate) fn collect(map: &Map, free: &[KeyframeId], focal_px: f64) -> (Bundle, Index) {
    let mut all = Collection {
        map,
        bundle: Bundle::default(),
        index: Index { keyframes: free.to_vec(), landmarks: Vec::new() },
        camera_of: vec![None; map.num_keyframe_ids()],
        num_free: free.len(),
    };
    for (i, id) in free.iter().enumerate() {
        all.camera_of[id.index()] = Some(i);
        all.bundle.cameras.push(*map.keyframe(*id).camera_from_world());
        all.bundle.is_free.push(true);
    }
    let landmarks = seen_by(map, free);
    let num_observations = landmarks.iter().map(|id| map.landmark(*id).observations.len()).sum();
    // A whole map has so many that there is no room to be wasted.
    all.bundle.observations.reserve_exact(num_observations);
    for (point, id) in landmarks.iter().enumerate() {
        let landmark = map.landmark(*id);
        all.bundle.points.push(landmark.point_in_world);
        for observation in landmark.observations.iter() {
            let keyframe = observation.keyframe;
            let camera = all.camera(keyframe);
            all.bundle.observations.push(BundleObservation {
                point,
                camera,
                ray: Vector2::new(observation.ray.x, observation.ray.y),
                whitening: whitening(focal_of(map, keyframe, focal_px), &observation.covariance_px),
            });
        }
    }
    all.index.landmarks = landmarks;
    all.tie_turned();
    all.add_odometry();
    all.add_crossings();
    let Collection { mut bundle, index, .. } = all;
    fix_gauge(&mut bundle, &index);
    (bundle, index)
}

/// Landmarks that these keyframes see and that tell something of their poses.
fn seen_by(map: &Map, keyframes: &[KeyframeId]) -> Vec<LandmarkId> {
    let mut is_listed = vec![false; map.num_landmark_ids()];
    let mut seen = Vec::new();
    for id in keyframes.iter().flat_map(|keyframe| map.keyframe(*keyframe).landmarks.iter()) {
        let landmark = map.landmark(*id);
        let is_usable = landmark.is_converged() && landmark.observations.len() >= 2;
        if is_usable && !std::mem::replace(&mut is_listed[id.index()], true) {
            seen.push(*id);
        }
    }
    seen
}

/// Focal length of the camera of a keyframe, where that of the camera that is followed is known, pixels.
fn focal_of(map: &Map, keyframe: KeyframeId, own_focal_px: f64) -> f64 {
    map.keyframe(keyframe).foreign.as_ref().map_or(own_focal_px, |foreign| focal_px(&foreign.camera))
}

/// Distance of two keyframes between which the camera only turned, share of the depth of the scene. Once a map is complete twice as much is the error of
/// how far neighbors have moved, and half as many radians that of their turn, which landmarks far away tell better.
const NEIGHBOR_SIGMA: f64 = 0.001;

/// A bundle while it is collected.
struct Collection<'a> {
    map: &'a Map,
    bundle: Bundle,
    index: Index,
    /// Index in the bundle of each keyframe of the map.
    camera_of: Vec<Option<usize>>,
    /// The first so many may move.
    num_free: usize,
}

impl Collection<'_> {
    /// Index of a keyframe; one that is not there yet joins and stays where it is.
    fn camera(&mut self, id: KeyframeId) -> usize {
        *self.camera_of[id.index()].get_or_insert_with(|| {
            self.index.keyframes.push(id);
            self.bundle.cameras.push(*self.map.keyframe(id).camera_from_world());
            self.bundle.is_free.push(false);
            self.index.keyframes.len() - 1
        })
    }

    /// Indices of two keyframes; `None` if neither may move.
    fn pair(&mut self, first: KeyframeId, second: KeyframeId) -> Option<(usize, usize)> {
        let is_free =
            |id: KeyframeId| self.camera_of[id.index()].is_some_and(|camera| camera < self.num_free);
        (is_free(first) || is_free(second)).then(|| (self.camera(first), self.camera(second)))
    }

    /// Holds keyframes together between which the camera only turned; their landmarks may say little of where they are.
    fn tie_turned(&mut self) {
        let map = self.map;
        for (id, _) in map.keyframes() {
            let Some(other) = map.turned_from(id) else { continue };
            let Some(cameras) = self.pair(id, other) else { continue };
            let sigma = NEIGHBOR_SIGMA * map.depth_of(other).or_else(|| map.depth_of(id)).unwrap_or(1.0);
            self.bundle.ties.push(BundleTie { cameras, sigma });
        }
    }

    /// Holds keyframes together by odometry: each with the one before, and with the last one from which it is so far away that the
    /// length of the way is sure. Without the second kind the unit of length would drift.
    fn add_odometry(&mut self) {
        let known: Vec<(KeyframeId, OdomPose)> =
            self.map.keyframes().filter_map(|(id, keyframe)| Some((id, keyframe.odometry?))).collect();
        for (i, (id, odometry)) in known.iter().enumerate() {
            let before = known[..i].iter().rev();
            let motions = before.map_while(|(id, pose)| Some((*id, pose.motion_to(odometry)?)));
            let far = motions.clone().find(|(_, motion)| motion.translation().norm() >= SURE_WAY_M);
            for (other, second_from_first) in motions.take(1).chain(far) {
                let Some(cameras) = self.pair(other, *id) else { continue };
                let deviations = motion_deviations(&second_from_first);
                self.bundle.motions.push(BundleMotion { cameras, second_from_first, deviations });
            }
        }
    }

    /// Holds parts of the map together that were maps of their own, where both know the same frame.
    fn add_crossings(&mut self) {
        for crossing in self.map.crossings() {
            let Crossing { before, after } = crossing;
            let Some(cameras) = self.pair(before.keyframe, after.keyframe) else { continue };
            let variances = crossing.covariance().diagonal();
            let [along, about] = [0, 3].map(|first| variances.fixed_rows::<3>(first).mean().sqrt());
            // The frame may be far from the keyframe that hears of its turn.
            let lever = about * after.camera_from_keyframe.translation().norm();
            self.bundle.motions.push(BundleMotion {
                cameras,
                second_from_first: after.camera_from_keyframe.inverse() * before.camera_from_keyframe,
                deviations: (along.hypot(lever), about),
            });
        }
    }
}

/// A bundle whose keyframes may all move is held at the oldest of them.
fn fix_gauge(bundle: &mut Bundle, index: &Index) {
    if bundle.is_free.iter().all(|is_free| *is_free)
        && let Some(oldest) = (0..index.keyframes.len()).min_by_key(|i| index.keyframes[*i])
    {
        bundle.is_free[oldest] = false;
    }
}
