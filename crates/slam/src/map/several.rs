//! Several maps in one store: starting, giving up, correcting and joining them.

use std::sync::Arc;

use visloc_core::geom::{CameraFrame, Rigid3};

use super::{
    Keyframe, KeyframeId, Landmark, LandmarkId, LandmarkState, Map, MapId, Packing,
    keyframe::Anchor,
    store::{center, scaled},
};
use crate::{
    lie::CameraFromWorld,
    recognize::{PlaceIndex, View},
};

/// A new pose of a keyframe.
#[derive(Debug, Clone, Copy)]
pub struct Correction {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Its new pose.
    pub camera_from_world: CameraFromWorld,
    /// Factor on all lengths that are measured from it.
    pub scale: f64,
}

/// By how much the numbers of keyframes and landmarks grow when a map is appended to others.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Offsets {
    keyframes: u32,
    landmarks: u32,
    maps: u32,
}

impl Offsets {
    /// The number of a keyframe after the map was appended.
    #[must_use]
    pub fn keyframe(&self, id: KeyframeId) -> KeyframeId {
        KeyframeId(id.0 + self.keyframes)
    }

    /// The number of a map after it was appended.
    #[must_use]
    pub fn map(&self, id: MapId) -> MapId {
        MapId(id.0 + self.maps)
    }

    /// The number of a landmark after the map was appended.
    #[must_use]
    pub fn landmark(&self, id: LandmarkId) -> LandmarkId {
        LandmarkId(id.0 + self.landmarks)
    }
}

impl Map {
    /// The map that is tracked and grows.
    #[inline]
    #[must_use]
    pub fn active(&self) -> MapId {
        self.active
    }

    /// Fixes all that is in the maps now: its keyframes stay where they are, whatever comes later, and its landmarks stay in the map.
    pub fn fix(&mut self) {
        self.num_fixed_keyframes = self.keyframes.len();
        self.num_fixed_landmarks = self.landmarks.len();
    }

    /// Whether a keyframe stays where it is.
    #[inline]
    #[must_use]
    pub fn is_fixed(&self, id: KeyframeId) -> bool {
        id.index() < self.num_fixed_keyframes
    }

    /// Whether a landmark stays in the map.
    #[inline]
    #[must_use]
    pub fn is_fixed_landmark(&self, id: LandmarkId) -> bool {
        id.index() < self.num_fixed_landmarks
    }

    /// Whether a part of the maps is fixed.
    #[must_use]
    pub fn has_fixed(&self) -> bool {
        self.num_fixed_keyframes > 0
    }

    /// The keyframes of the map that is tracked that may move, in order of creation.
    pub fn free_keyframes(&self) -> impl DoubleEndedIterator<Item = (KeyframeId, &Keyframe)> {
        self.keyframes().filter(|(id, _)| !self.is_fixed(*id))
    }

    /// The maps that have keyframes, oldest first.
    #[must_use]
    pub fn maps(&self) -> Vec<MapId> {
        let mut maps: Vec<MapId> = self.all_keyframes().map(|(_, keyframe)| keyframe.map).collect();
        maps.sort_unstable();
        maps.dedup();
        maps
    }

    /// The map that a keyframe belongs to; a culled one belongs to the map of the keyframe that it hangs on. `None` if the map
    /// was given up.
    #[must_use]
    pub fn map_of(&self, id: KeyframeId) -> Option<MapId> {
        let keyframe = self.keyframe(id);
        match &keyframe.anchor {
            Some(anchor) => self.map_of(anchor.keyframe),
            None => (!keyframe.is_given_up).then_some(keyframe.map),
        }
    }

    /// The keyframe itself, or the one that is still there on which it hangs.
    #[must_use]
    pub fn standing_for(&self, id: KeyframeId) -> KeyframeId {
        self.keyframe(id).anchor.as_ref().map_or(id, |anchor| self.standing_for(anchor.keyframe))
    }

    /// Goes on with another map.
    pub fn activate(&mut self, map: MapId) {
        self.active = map;
    }

    /// A copy that goes on with another map.
    #[must_use]
    pub fn with_active(&self, map: MapId) -> Self {
        Self { active: map, ..self.clone() }
    }

    fn offsets(&self) -> Offsets {
        Offsets {
            keyframes: self.keyframes.len() as u32,
            landmarks: self.landmarks.len() as u32,
            maps: self.num_maps,
        }
    }

    /// Appends a map that has just been started and goes on with it.
    pub fn append(&mut self, started: &Self) -> Offsets {
        let offsets = self.append_all(started);
        self.active = MapId(offsets.maps);
        self.num_maps = offsets.maps + 1;
        offsets
    }

    /// Appends all maps of another store, each as a map of its own, which can be recognized as before.
    pub fn append_all(&mut self, others: &Self) -> Offsets {
        let offsets = self.offsets();
        for (id, keyframe) in (0..).map(KeyframeId).zip(others.keyframes.iter()) {
            let view = keyframe.view.as_deref();
            let view = view.map(|view| Arc::new(view.renumbered(|landmark| offsets.landmark(landmark))));
            if let Some(view) = &view {
                Arc::make_mut(&mut self.index).add(offsets.keyframe(id), view);
            }
            let anchor = keyframe
                .anchor
                .map(|anchor| Anchor { keyframe: offsets.keyframe(anchor.keyframe), ..anchor });
            self.keyframes.push(Keyframe {
                map: offsets.map(keyframe.map),
                landmarks: Arc::new(keyframe.landmarks.iter().map(|id| offsets.landmark(*id)).collect()),
                turned_from: keyframe.turned_from.map(|id| offsets.keyframe(id)),
                anchor,
                view,
                ..keyframe.clone()
            });
        }
        for landmark in others.landmarks.iter() {
            let observations = landmark.observations.renumbered(|id| offsets.keyframe(id));
            self.landmarks.push(Landmark { observations, ..landmark.clone() });
        }
        self.num_maps += others.num_maps;
        offsets
    }

    /// Lets go of what was fixed.
    pub fn release(&mut self) {
        (self.num_fixed_keyframes, self.num_fixed_landmarks) = (0, 0);
    }

    /// Takes a whole map out: its start was wrong.
    pub fn give_up(&mut self, map: MapId) {
        let of_map: Vec<KeyframeId> =
            self.all_keyframes().filter(|(_, k)| k.map == map).map(|(id, _)| id).collect();
        for id in of_map {
            self.forget_view(id);
            let landmarks = Arc::clone(&self.keyframes[id.index()].landmarks);
            for landmark in landmarks.iter().copied() {
                self.remove_landmark(landmark);
            }
            let keyframe = &mut self.keyframes[id.index()];
            keyframe.is_given_up = true;
            keyframe.picture = None;
        }
        let is_kept = |id: KeyframeId| !self.keyframes[id.index()].is_given_up;
        self.crossings.retain(|known| is_kept(known.before.keyframe) && is_kept(known.after.keyframe));
    }

    /// Unit of length of a keyframe, in units of the time when it was made.
    #[must_use]
    pub fn scale_of(&self, id: KeyframeId) -> f64 {
        let keyframe = self.keyframe(id);
        match &keyframe.anchor {
            None => keyframe.scale,
            Some(anchor) => keyframe.scale * self.scale_of(anchor.keyframe) / anchor.scale,
        }
    }

    /// Moves keyframes, each with a scale of its own. A landmark moves with the first of them that sees it.
    pub fn correct(&mut self, corrections: &[Correction]) {
        let mut is_moved = vec![false; self.landmarks.len()];
        for correction in corrections {
            let keyframe = &self.keyframes[correction.keyframe.index()];
            let before = keyframe.camera_from_world;
            let world_from_camera = correction.camera_from_world.inverse();
            for index in keyframe.landmarks.iter().map(|landmark| landmark.index()) {
                let is_candidate = self.landmarks[index].state() == LandmarkState::Candidate;
                let is_foreign = is_candidate && self.landmarks[index].host().keyframe != correction.keyframe;
                if is_foreign || std::mem::replace(&mut is_moved[index], true) {
                    continue;
                }
                let landmark = &mut self.landmarks[index];
                let point_in_camera = before.transform(&landmark.point_in_world) * correction.scale;
                landmark.point_in_world = world_from_camera.transform(&point_in_camera);
                if is_candidate {
                    landmark.scale_depth(correction.scale);
                }
            }
            let keyframe = &mut self.keyframes[correction.keyframe.index()];
            keyframe.camera_from_world = correction.camera_from_world;
            keyframe.center_in_world = center(&correction.camera_from_world);
            keyframe.scale *= correction.scale;
        }
    }

    /// Multiplies all lengths of a map by a factor.
    pub fn enlarge(&mut self, map: MapId, factor: f64) {
        let corrections: Vec<Correction> = self
            .all_keyframes()
            .filter(|(_, keyframe)| keyframe.map == map)
            .map(|(id, keyframe)| Correction {
                keyframe: id,
                camera_from_world: scaled(keyframe.camera_from_world(), factor),
                scale: factor,
            })
            .collect();
        self.correct(&corrections);
    }

    /// Takes keyframes out of the maps, in a copy that is only searched.
    pub fn hide(&mut self, keyframes: impl Iterator<Item = KeyframeId>) {
        for id in keyframes {
            self.keyframes[id.index()].map = MapId(u32::MAX);
        }
    }

    /// Whether a map was made with odometry: its lengths are meters. In no other map does a keyframe have odometry.
    #[must_use]
    pub fn is_in_meters(&self, map: MapId) -> bool {
        self.all_keyframes().any(|(_, keyframe)| keyframe.map == map && keyframe.odometry.is_some())
    }

    /// Leaves odometry out of all maps.
    pub fn forget_odometry(&mut self) {
        for index in 0..self.keyframes.len() {
            self.keyframes[index].odometry = None;
        }
    }

    /// Makes one map of two that are in the same frame.
    pub fn join(&mut self, map: MapId, into: MapId) {
        let is_in_meters = self.is_in_meters(into);
        let of_map: Vec<KeyframeId> =
            self.all_keyframes().filter(|(_, k)| k.map == map).map(|(id, _)| id).collect();
        for id in of_map {
            let keyframe = &mut self.keyframes[id.index()];
            keyframe.map = into;
            keyframe.odometry = keyframe.odometry.filter(|_| is_in_meters);
        }
        if self.active == map {
            self.active = into;
        }
    }

    /// Makes one landmark of two that are the same: the second is taken out, and the first is seen where it was seen.
    pub fn fuse(&mut self, kept: LandmarkId, removed: LandmarkId) {
        if kept == removed || !self.landmark(kept).is_converged() || !self.landmark(removed).is_alive() {
            return;
        }
        let observations = self.landmark(removed).observations.clone();
        let counts = (self.landmark(removed).num_visible, self.landmark(removed).num_found);
        self.remove_landmark(removed);
        for observation in observations.iter() {
            self.add_observation(kept, observation);
        }
        let landmark = self.landmark_mut(kept);
        landmark.num_visible += counts.0;
        landmark.num_found += counts.1;
        landmark.num_missed = 0;
    }

    /// Finds keyframes of all maps by what they look like.
    #[must_use]
    pub fn index(&self) -> &PlaceIndex {
        &self.index
    }

    /// Notes what a keyframe looks like, so that it can be found.
    pub fn describe(&mut self, id: KeyframeId, view: View) {
        let view = Arc::new(view);
        Arc::make_mut(&mut self.index).add(id, &view);
        self.keyframes[id.index()].view = Some(view);
    }

    /// Packs the image of a keyframe that is at hand.
    pub(crate) fn pack_picture(&mut self, id: KeyframeId, packing: &Packing) {
        if let Some(packed) = self.keyframe(id).picture.as_ref().and_then(|picture| packing.packed(picture)) {
            self.keyframes[id.index()].picture = Some(packed);
        }
    }

    /// Forgets what a keyframe looks like.
    pub(super) fn forget_view(&mut self, id: KeyframeId) {
        if let Some(view) = self.keyframes[id.index()].view.take() {
            Arc::make_mut(&mut self.index).remove(id, &view);
        }
    }

    /// Pose of a frame that hangs on a keyframe, given the scale that the keyframe had then.
    #[must_use]
    pub fn pose_on(
        &self,
        keyframe: KeyframeId,
        camera_from_keyframe: &Rigid3<CameraFrame, CameraFrame>,
        scale: f64,
    ) -> CameraFromWorld {
        scaled(camera_from_keyframe, self.scale_of(keyframe) / scale) * self.pose_of(keyframe)
    }
}
