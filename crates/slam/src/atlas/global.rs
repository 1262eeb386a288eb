//! Adjustment of a whole map, a step at a time beside the mapper's other work.

use crate::{
    map::{Correction, KeyframeId, Map, MapId},
    mapping::{MOST_KEYFRAMES, WholeAdjustment},
};

/// Steps of the adjustment.
const MOST_STEPS: usize = 15;

/// An adjustment under way. It works on a copy, and new keyframes follow what it does to the old ones.
#[derive(Debug)]
pub struct GlobalAdjustment {
    map: MapId,
    adjustment: WholeAdjustment,
    num_steps: usize,
    is_done: bool,
}

impl GlobalAdjustment {
    /// Starts with the map that is tracked; `None` if it is too large.
    #[must_use]
    pub fn start(map: &Map, focal_px: f64) -> Option<Self> {
        let ids: Vec<KeyframeId> = map.free_keyframes().map(|(id, _)| id).collect();
        (1..=MOST_KEYFRAMES).contains(&ids.len()).then(|| Self {
            map: map.active(),
            adjustment: WholeAdjustment::new(map, &ids, focal_px),
            num_steps: 0,
            is_done: false,
        })
    }

    /// Does one step; says whether it was the last.
    pub fn step(&mut self) -> bool {
        if !self.is_done {
            self.num_steps += 1;
            let has_gained = self.adjustment.step();
            self.is_done = !has_gained || self.num_steps >= MOST_STEPS;
        }
        self.is_done
    }

    /// Moves the map as the adjustment says.
    pub fn apply(&self, map: &mut Map) {
        if map.active() != self.map {
            return;
        }
        let adjusted = self.adjustment.keyframes();
        let new_pose = |id: KeyframeId| {
            adjusted.binary_search_by_key(&id, |(other, _)| *other).ok().map(|i| adjusted[i].1)
        };
        let mut corrections = Vec::new();
        for (id, keyframe) in map.free_keyframes() {
            let pose = new_pose(id).or_else(|| {
                let connected = map.connected(id, 1);
                let known =
                    connected.iter().map(|(other, _)| *other).find(|other| new_pose(*other).is_some());
                let reference = known.or_else(|| adjusted.last().map(|(last, _)| *last))?;
                let from_reference = *keyframe.camera_from_world() * map.pose_of(reference).inverse();
                Some(from_reference * new_pose(reference)?)
            });
            if let Some(camera_from_world) = pose {
                corrections.push(Correction { keyframe: id, camera_from_world, scale: 1.0 });
            }
        }
        map.correct(&corrections);
        self.adjustment.move_landmarks(map);
    }
}
