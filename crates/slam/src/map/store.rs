//! The only place that changes the links between keyframes and landmarks.

use std::sync::Arc;

use nalgebra::{Point3, Rotation3};
use visloc_core::{
    Timestamp,
    geom::{Camera, Rigid3},
    median,
};

use super::{
    Crossing, Keyframe, KeyframeId, KeyframePicture, Landmark, LandmarkId, LandmarkState, MapId, Observation,
    keyframe::Anchor, push_tightly, shared_vec::SharedVec,
};
use crate::{
    feature::gradient_noise,
    image::Pyramid,
    lie::CameraFromWorld,
    mapping::DepthFilter,
    odometry::OdomPose,
    recognize::PlaceIndex,
    shutter::{Exposure, Readout},
    track::TrackReport,
};

/// What a keyframe is made from.
#[derive(Debug, Clone)]
pub struct NewKeyframe {
    /// Number of the frame in the sequence.
    pub frame: usize,
    /// When it was taken.
    pub at: Timestamp,
    /// Its images.
    pub pyramid: Arc<Pyramid>,
    /// Its pose.
    pub camera_from_world: CameraFromWorld,
    /// The keyframe that it has only turned from.
    pub turned_from: Option<KeyframeId>,
    /// Where the odometry has it.
    pub odometry: Option<OdomPose>,
}

/// Keyframes and landmarks of one map or of several, each in a frame of its own until they are joined; one of them is tracked.
/// Invariants: a landmark lists an observation in a keyframe exactly if the keyframe lists the
/// landmark; both are alive; a landmark that is alive has at least one observation. Copies are cheap: they share what has not
/// changed since.
#[derive(Debug, Clone)]
pub struct Map {
    pub(super) keyframes: SharedVec<Keyframe>,
    pub(super) landmarks: SharedVec<Landmark>,
    /// Stands for every landmark that was removed.
    pub(super) removed: Arc<Landmark>,
    /// The map that is tracked and grows.
    pub(super) active: MapId,
    /// How many map numbers were given out.
    pub(super) num_maps: u32,
    /// Finds keyframes of all maps by what they look like.
    pub(super) index: Arc<PlaceIndex>,
    /// Keyframes that stay where they are: the first ones.
    pub(super) num_fixed_keyframes: usize,
    /// Landmarks that stay in the map: the first ones.
    pub(super) num_fixed_landmarks: usize,
    /// Frames that two maps know.
    pub(super) crossings: Vec<Crossing>,
}

impl Default for Map {
    fn default() -> Self {
        Self::new()
    }
}

impl Map {
    /// An empty map.
    #[must_use]
    pub fn new() -> Self {
        Self {
            keyframes: SharedVec::default(),
            landmarks: SharedVec::default(),
            removed: Arc::new(Landmark::removed()),
            active: MapId::default(),
            num_maps: 0,
            index: Arc::default(),
            num_fixed_keyframes: 0,
            num_fixed_landmarks: 0,
            crossings: Vec::new(),
        }
    }

    /// A keyframe, culled ones included.
    #[inline]
    #[must_use]
    pub fn keyframe(&self, id: KeyframeId) -> &Keyframe {
        &self.keyframes[id.index()]
    }

    /// A landmark; of one that was removed nothing but that is known.
    #[inline]
    #[must_use]
    pub fn landmark(&self, id: LandmarkId) -> &Landmark {
        &self.landmarks[id.index()]
    }

    /// A landmark, to update what is known of it. Observations are changed through the map only.
    #[inline]
    pub(crate) fn landmark_mut(&mut self, id: LandmarkId) -> &mut Landmark {
        &mut self.landmarks[id.index()]
    }

    /// The keyframes of the map that is tracked, in order of creation.
    pub fn keyframes(&self) -> impl DoubleEndedIterator<Item = (KeyframeId, &Keyframe)> {
        self.all_keyframes().filter(|(_, keyframe)| keyframe.map == self.active)
    }

    /// The keyframes of all maps, in order of creation.
    pub fn all_keyframes(&self) -> impl DoubleEndedIterator<Item = (KeyframeId, &Keyframe)> {
        let ids = (0..self.keyframes.len() as u32).map(KeyframeId);
        ids.map(|id| (id, self.keyframe(id))).filter(|(_, keyframe)| keyframe.is_alive())
    }

    /// The landmarks of the map that is tracked, in order of creation.
    pub fn landmarks(&self) -> impl Iterator<Item = (LandmarkId, &Landmark)> {
        self.all_landmarks().filter(|(_, l)| self.keyframe(l.observations.keyframe_at(0)).map == self.active)
    }

    /// The landmarks of all maps, in order of creation.
    pub fn all_landmarks(&self) -> impl Iterator<Item = (LandmarkId, &Landmark)> {
        (0_u32..).map(LandmarkId).zip(self.landmarks.iter()).filter(|(_, landmark)| landmark.is_alive())
    }

    /// How many landmark numbers were given out.
    #[must_use]
    pub fn num_landmark_ids(&self) -> usize {
        self.landmarks.len()
    }

    /// How many keyframe numbers were given out.
    #[must_use]
    pub fn num_keyframe_ids(&self) -> usize {
        self.keyframes.len()
    }

    /// Appends a keyframe without landmarks.
    pub fn add_keyframe(&mut self, new: NewKeyframe) -> KeyframeId {
        let id = KeyframeId(self.keyframes.len() as u32);
        self.keyframes.push(Keyframe {
            frame: new.frame,
            at: new.at,
            view: None,
            map: self.active,
            gradient_noise: gradient_noise(&new.pyramid, usize::MAX),
            foreign: None,
            picture: Some(KeyframePicture::Here(new.pyramid)),
            landmarks: Arc::default(),
            camera_from_world: new.camera_from_world,
            center_in_world: center(&new.camera_from_world),
            scale: 1.0,
            anchor: None,
            is_given_up: false,
            turned_from: new.turned_from,
            odometry: new.odometry,
            exposure: None,
        });
        id
    }

    /// Takes note of how a keyframe was exposed.
    pub(crate) fn set_exposure(&mut self, id: KeyframeId, exposure: Option<Exposure>) {
        self.keyframes[id.index()].exposure = exposure;
    }

    /// Puts all keyframes right whose exposure is known: the camera is known to have another readout than they were put right with.
    pub(crate) fn put_right(&mut self, readout: &Readout, camera: &Camera) {
        for index in 0..self.keyframes.len() {
            let keyframe = &self.keyframes[index];
            let left = keyframe.exposure.map(|exposure| exposure.left_by(readout));
            let Some(left) = left.filter(|left| !left.readout.is_at_once()) else { continue };
            let Some(pyramid) = keyframe.pyramid() else { continue };
            let image = left.at_once(pyramid.level(0), camera);
            let keyframe = &mut self.keyframes[index];
            keyframe.picture =
                Some(KeyframePicture::Here(Arc::new(Pyramid::new(image, pyramid.num_levels()))));
            keyframe.exposure = Some(Exposure { readout: *readout, ..left });
            let seen: Vec<usize> = keyframe.landmarks.iter().map(|landmark| landmark.index()).collect();
            for landmark in seen {
                let observations = &mut self.landmarks[landmark].observations;
                observations.put_right(KeyframeId(index as u32), &left, camera);
            }
        }
    }

    /// Moves a keyframe. Its candidates move with it.
    pub fn set_pose(&mut self, id: KeyframeId, camera_from_world: CameraFromWorld) {
        let keyframe = &mut self.keyframes[id.index()];
        keyframe.camera_from_world = camera_from_world;
        keyframe.center_in_world = center(&camera_from_world);
        let world_from_camera = camera_from_world.inverse();
        for index in keyframe.landmarks.iter().map(|landmark| landmark.index()) {
            let landmark = &self.landmarks[index];
            if landmark.state() == LandmarkState::Candidate && landmark.host().keyframe == id {
                let Some(filter) = &landmark.filter else { continue };
                let point = landmark.host().ray / filter.inverse_depth();
                self.landmarks[index].point_in_world = world_from_camera.transform(&point.into());
            }
        }
    }

    /// Makes the rays of all observations of the camera that is followed anew: it is known better.
    pub(crate) fn look_through(&mut self, camera: &Camera) {
        let is_own: Vec<bool> = self.keyframes.iter().map(|keyframe| keyframe.foreign.is_none()).collect();
        for index in 0..self.landmarks.len() {
            let landmark = &self.landmarks[index];
            // What stays as it is stays shared with other copies.
            let is_own = |id: KeyframeId| is_own[id.index()];
            if landmark.is_alive() && !landmark.observations.are_through(camera, is_own) {
                self.landmarks[index].observations.look_through(camera, is_own);
            }
        }
    }

    /// The surroundings of a keyframe have grown by a factor: its candidates and the frames that hang on it follow.
    pub(crate) fn note_growth(&mut self, id: KeyframeId, factor: f64) {
        let candidates: Vec<usize> = self.keyframes[id.index()].landmarks.iter().map(|l| l.index()).collect();
        for index in candidates {
            let landmark = &mut self.landmarks[index];
            if landmark.state() == LandmarkState::Candidate && landmark.host().keyframe == id {
                landmark.scale_depth(factor);
            }
        }
        self.keyframes[id.index()].scale *= factor;
        let pose = self.keyframes[id.index()].camera_from_world;
        self.set_pose(id, pose);
    }

    /// Appends a landmark that one keyframe sees.
    pub fn add_landmark(
        &mut self,
        host: Observation,
        filter: DepthFilter,
        state: LandmarkState,
    ) -> LandmarkId {
        let id = LandmarkId(self.landmarks.len() as u32);
        let keyframe = &mut self.keyframes[host.keyframe.index()];
        push_tightly(Arc::make_mut(&mut keyframe.landmarks), id);
        let point_in_camera = host.ray / filter.inverse_depth();
        self.landmarks.push(Landmark {
            point_in_world: keyframe.camera_from_world.inverse().transform(&point_in_camera.into()),
            observations: vec![host].into(),
            filter: (state == LandmarkState::Candidate).then(|| Box::new(filter)),
            num_visible: 1,
            num_found: 1,
            num_missed: 0,
            made_at: keyframe.frame as u32,
        });
        id
    }

    /// Links a landmark to a keyframe that sees it; nothing happens if they are linked already or one is not alive.
    pub fn add_observation(&mut self, id: LandmarkId, observation: Observation) {
        let keyframe = observation.keyframe.index();
        let is_linked = self.landmark(id).observation_in(observation.keyframe).is_some();
        if self.landmark(id).is_alive() && self.keyframes[keyframe].is_alive() && !is_linked {
            self.landmarks[id.index()].observations.push(observation);
            push_tightly(Arc::make_mut(&mut self.keyframes[keyframe].landmarks), id);
        }
    }

    /// Unlinks a landmark from a keyframe. A converged landmark with fewer than two observations left is removed. What a fixed keyframe
    /// sees stays.
    pub fn remove_observation(&mut self, id: LandmarkId, keyframe: KeyframeId) {
        if self.is_fixed(keyframe) {
            return;
        }
        let landmark = &mut self.landmarks[id.index()];
        landmark.observations.remove(keyframe);
        let least = if landmark.is_converged() { 2 } else { 1 };
        let is_too_few = landmark.observations.len() < least;
        Arc::make_mut(&mut self.keyframes[keyframe.index()].landmarks).retain(|other| *other != id);
        if is_too_few {
            self.remove_landmark(id);
        }
    }

    /// Unlinks a landmark from a keyframe that is not its host, and keeps the landmark in any case.
    pub(crate) fn remove_candidate_observation(&mut self, id: LandmarkId, keyframe: KeyframeId) {
        let landmark = &mut self.landmarks[id.index()];
        if landmark.observations.keyframes().next().is_none_or(|host| host == keyframe) {
            return;
        }
        landmark.observations.remove(keyframe);
        Arc::make_mut(&mut self.keyframes[keyframe.index()].landmarks).retain(|other| *other != id);
    }

    /// Takes a landmark out of the map.
    pub fn remove_landmark(&mut self, id: LandmarkId) {
        let keyframes: Vec<KeyframeId> = self.landmark(id).observations.keyframes().collect();
        self.landmarks.share(id.index(), &self.removed);
        for keyframe in keyframes {
            Arc::make_mut(&mut self.keyframes[keyframe.index()].landmarks).retain(|other| *other != id);
        }
    }

    /// Takes a keyframe out of the map; it stays as a place in the trajectory, hanging on `anchor`. Candidates hosted by it
    /// are removed.
    pub fn cull_keyframe(&mut self, id: KeyframeId, anchor: KeyframeId) {
        self.forget_view(id);
        let Keyframe { camera_from_world: anchor_from_world, scale, .. } = self.keyframes[anchor.index()];
        let keyframe = &mut self.keyframes[id.index()];
        let camera_from_anchor = keyframe.camera_from_world * anchor_from_world.inverse();
        keyframe.anchor = Some(Anchor { keyframe: anchor, camera_from_anchor, scale });
        keyframe.picture = None;
        for landmark in std::mem::take(&mut keyframe.landmarks).iter().copied() {
            let is_hosted_candidate = {
                let landmark = &self.landmarks[landmark.index()];
                !landmark.is_converged() && landmark.host().keyframe == id
            };
            if is_hosted_candidate {
                self.remove_landmark(landmark);
            } else {
                self.remove_observation(landmark, id);
            }
        }
    }

    /// Notes which landmarks were looked for and which were found.
    pub(crate) fn count_matches(&mut self, report: &TrackReport) {
        for id in &report.tried {
            if self.landmark(*id).is_converged() {
                let landmark = self.landmark_mut(*id);
                landmark.num_visible += 1;
                landmark.num_missed += 1;
            }
        }
        for feature in &report.frame.features {
            if self.landmark(feature.landmark).is_converged() {
                let landmark = self.landmark_mut(feature.landmark);
                landmark.num_found += 1;
                landmark.num_missed = 0;
            }
        }
    }

    /// Pose of any keyframe; a culled one moves with the keyframe that it hangs on.
    #[must_use]
    pub fn pose_of(&self, id: KeyframeId) -> CameraFromWorld {
        match &self.keyframes[id.index()].anchor {
            None => self.keyframes[id.index()].camera_from_world,
            Some(Anchor { keyframe, camera_from_anchor, scale }) => {
                let grown = self.scale_of(*keyframe) / scale;
                scaled(camera_from_anchor, grown) * self.pose_of(*keyframe)
            }
        }
    }

    /// The keyframe, still part of the map, that this one has only turned from.
    #[must_use]
    pub fn turned_from(&self, id: KeyframeId) -> Option<KeyframeId> {
        let mut other = self.keyframe(id).turned_from;
        while let Some(culled) = other.filter(|other| !self.keyframe(*other).is_alive()) {
            other = self.keyframe(culled).turned_from;
        }
        other
    }

    /// Keyframes that share at least `min_shared` converged landmarks with the given ones, most shared first.
    #[must_use]
    pub fn sharing(&self, landmarks: &[LandmarkId], min_shared: u32) -> Vec<(KeyframeId, u32)> {
        most_shared(&self.num_shared(landmarks), min_shared)
    }

    /// How many of the landmarks are converged and seen by each keyframe.
    pub(crate) fn num_shared(&self, landmarks: &[LandmarkId]) -> Vec<u32> {
        let mut counts = vec![0_u32; self.keyframes.len()];
        // First all landmarks, then what sees them: so the processor fetches many at a time.
        let landmarks = landmarks.iter().map(|id| self.landmark(*id));
        let converged: Vec<&Landmark> = landmarks.filter(|landmark| landmark.is_converged()).collect();
        for landmark in converged {
            for keyframe in landmark.observations.keyframes() {
                counts[keyframe.index()] += 1;
            }
        }
        counts
    }

    /// Keyframes connected to one, most shared landmarks first, without itself.
    #[must_use]
    pub fn connected(&self, id: KeyframeId, min_shared: u32) -> Vec<(KeyframeId, u32)> {
        let mut connected = self.sharing(&self.keyframe(id).landmarks, min_shared);
        connected.retain(|(other, _)| *other != id);
        connected
    }

    /// Median depth of the landmarks of a keyframe, map units; `None` without landmarks.
    #[must_use]
    pub fn depth_of(&self, id: KeyframeId) -> Option<f64> {
        let keyframe = self.keyframe(id);
        let point = |id: &LandmarkId| self.landmark(*id).point_in_world;
        let depth = |id: &LandmarkId| keyframe.camera_from_world().transform(&point(id)).z;
        median(keyframe.landmarks.iter().map(depth).filter(|z| *z > 0.0))
    }

    /// Checks the invariants; the message names the first that is broken.
    ///
    /// # Errors
    /// If one is broken.
    pub fn check(&self) -> Result<(), String> {
        for (id, landmark) in self.all_landmarks() {
            if landmark.observations.is_empty() {
                return Err(format!("landmark {id:?} has no observation"));
            }
            for number in landmark.observations.keyframes() {
                let keyframe = self.keyframe(number);
                if !keyframe.is_alive() || keyframe.landmarks.iter().filter(|l| **l == id).count() != 1 {
                    return Err(format!("{number:?} does not list {id:?} once"));
                }
            }
        }
        for (id, keyframe) in self.all_keyframes() {
            let is_linked = |l: &LandmarkId| self.landmark(*l).observation_in(id).is_some();
            if !keyframe.landmarks.iter().all(is_linked) {
                return Err(format!("{id:?} lists a landmark that does not list it"));
            }
        }
        Ok(())
    }
}

/// Keyframes with at least so many shared landmarks, most shared first.
pub(crate) fn most_shared(num_shared: &[u32], min_shared: u32) -> Vec<(KeyframeId, u32)> {
    let all = (0..).map(KeyframeId).zip(num_shared.iter().copied());
    let mut sharing: Vec<(KeyframeId, u32)> = all.filter(|(_, count)| *count >= min_shared).collect();
    // Newer keyframes first among equals.
    sharing.sort_by_key(|(id, count)| std::cmp::Reverse((*count, *id)));
    sharing
}

/// A motion in another unit of length.
#[must_use]
pub fn scaled<A, B>(motion: &Rigid3<A, B>, factor: f64) -> Rigid3<A, B> {
    if factor == 1.0 {
        return *motion;
    }
    Rigid3::new(Rotation3::from_matrix_unchecked(*motion.rotation()), motion.translation() * factor)
}

pub(super) fn center(camera_from_world: &CameraFromWorld) -> Point3<f64> {
    Point3::from(*camera_from_world.inverse().translation())
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Point2, Vector3};
    use rand::RngExt;
    use visloc_core::{GrayImage, RngTree};

    use super::*;

    fn observation(keyframe: u32) -> Observation {
        let keyframe = KeyframeId(keyframe);
        let ray = Vector3::new(0.0, 0.0, 1.0);
        Observation { keyframe, px: Point2::origin(), ray, level: 0, covariance_px: Matrix2::identity() }
    }

    #[test]
    fn invariants_hold_after_random_changes() {
        for seed in 0..20 {
            let mut rng = RngTree::new(seed).stream("map", 0);
            let mut map = Map::new();
            let pyramid = Arc::new(Pyramid::new(GrayImage::new(40, 30), 1));
            for step in 0..300_usize {
                let keyframe =
                    rng.random_range(0..10_u32).min(map.num_keyframe_ids().saturating_sub(1) as u32);
                let landmark = LandmarkId(rng.random_range(0..map.num_landmark_ids().max(1)) as u32);
                let is_alive = map.num_keyframe_ids() > 0 && map.keyframe(KeyframeId(keyframe)).is_alive();
                let has_landmark = map.num_landmark_ids() > 0;
                match rng.random_range(0..8) {
                    0 if map.num_keyframe_ids() < 10 => {
                        let camera_from_world = CameraFromWorld::identity();
                        let at = Timestamp::default();
                        let pyramid = Arc::clone(&pyramid);
                        let turned_from = map.keyframes().next_back().map(|(id, _)| id);
                        map.add_keyframe(NewKeyframe {
                            frame: step,
                            at,
                            pyramid,
                            camera_from_world,
                            turned_from,
                            odometry: None,
                        });
                    }
                    1 | 2 if is_alive => {
                        let state =
                            if step % 2 == 0 { LandmarkState::Candidate } else { LandmarkState::Converged };
                        map.add_landmark(observation(keyframe), DepthFilter::new(1.0, 0.1), state);
                    }
                    3 | 4 if is_alive && has_landmark => map.add_observation(landmark, observation(keyframe)),
                    5 if is_alive && has_landmark => map.remove_observation(landmark, KeyframeId(keyframe)),
                    6 if has_landmark => map.remove_landmark(landmark),
                    7 if is_alive && map.keyframes().count() > 3 => {
                        let anchor = map.keyframes().map(|(id, _)| id).find(|id| id.0 != keyframe);
                        if let Some(anchor) = anchor {
                            map.cull_keyframe(KeyframeId(keyframe), anchor);
                        }
                    }
                    _ => {}
                }
                map.check().unwrap();
            }
        }
    }
}
