//! The first map.

use std::sync::Arc;

use nalgebra::Rotation3;
use visloc_core::{
    geom::{CameraFrame, Rigid3},
    median,
};

use crate::{
    atlas::Similarity,
    lie::CameraFromWorld,
    map::{Correction, KeyframeId, Map},
    track::Frame,
};

/// The first map.
#[derive(Debug)]
pub struct StartedMap {
    /// Two keyframes and their landmarks; the median depth of the first is 1.
    pub map: Map,
    /// The first keyframe.
    pub first: KeyframeId,
    /// The newest keyframe.
    pub second: KeyframeId,
    /// Frame of the newest keyframe.
    pub frame: Frame,
    /// Poses of the frames between the two keyframes, found afterwards: number and pose.
    pub between: Vec<(usize, CameraFromWorld)>,
}

impl StartedMap {
    /// Takes the map to another frame and unit of length.
    pub fn move_by(&mut self, similarity: &Similarity) {
        let correction = |id| Correction {
            keyframe: id,
            camera_from_world: similarity.pose(self.map.keyframe(id).camera_from_world()),
            scale: similarity.scale,
        };
        let corrections = [correction(self.first), correction(self.second)];
        self.map.correct(&corrections);
        self.frame.camera_from_world = similarity.pose(&self.frame.camera_from_world);
        for (_, pose) in &mut self.between {
            *pose = similarity.pose(pose);
        }
    }

    /// Leaves odometry out of it.
    pub fn forget_odometry(&mut self) {
        self.map.forget_odometry();
        self.frame.odometry = None;
    }
}

/// Scales a map of two keyframes, the first at the origin, so that the median depth of the first is 1.
pub(super) fn normalize_depth(map: &mut Map, first: KeyframeId, second: KeyframeId) {
    let ids = Arc::clone(&map.keyframe(first).landmarks);
    let depths = ids.iter().map(|id| map.landmark(*id).point_in_world.z);
    let scale = 1.0 / median(depths).unwrap_or(1.0).max(1e-9);
    let pose = map.keyframe(second).camera_from_world();
    let rotation = Rotation3::from_matrix_unchecked(*pose.rotation());
    let scaled: Rigid3<CameraFrame, _> = Rigid3::new(rotation, pose.translation() * scale);
    map.set_pose(second, scaled);
    for id in ids.iter().copied() {
        map.landmark_mut(id).point_in_world.coords *= scale;
    }
}
