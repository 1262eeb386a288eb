//! The part of the map that a frame may see.

use nalgebra::Point3;

use crate::{
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map},
};

/// Keyframes and landmarks around the camera.
#[derive(Debug, Clone, Default)]
pub struct LocalMap {
    /// Keyframes, most important first.
    pub keyframes: Vec<KeyframeId>,
    /// Their landmarks, each once.
    pub landmarks: Vec<LandmarkId>,
}

/// Collects keyframes that share landmarks with the last frame, then those that look at the same place from nearby, and the
/// landmarks of all of them. The second kind closes small loops: after a round trip the old landmarks are found again.
#[must_use]
pub fn collect_local_map(
    map: &Map,
    seen: &[LandmarkId],
    camera_from_world: &CameraFromWorld,
    scene_depth: f64,
    max_keyframes: usize,
) -> LocalMap {
    let mut keyframes: Vec<KeyframeId> =
        map.sharing(seen, 3).into_iter().map(|(id, _)| id).take(max_keyframes).collect();
    // Keyframes with candidates only, as under pure rotation, share nothing yet.
    for (id, _) in map.keyframes().rev().take(2) {
        if !keyframes.contains(&id) {
            keyframes.push(id);
        }
    }
    keyframes.extend(nearby(map, &keyframes, camera_from_world, scene_depth, max_keyframes / 2));
    let mut is_listed = vec![false; map.num_landmark_ids()];
    let mut landmarks = Vec::new();
    for keyframe in &keyframes {
        for id in map.keyframe(*keyframe).landmarks.iter() {
            if !std::mem::replace(&mut is_listed[id.index()], true) {
                landmarks.push(*id);
            }
        }
    }
    LocalMap { keyframes, landmarks }
}

/// Keyframes not yet listed whose camera is near and looks the same way, oldest first.
fn nearby(
    map: &Map,
    listed: &[KeyframeId],
    camera_from_world: &CameraFromWorld,
    scene_depth: f64,
    max: usize,
) -> Vec<KeyframeId> {
    let world_from_camera = camera_from_world.inverse();
    let center = Point3::from(*world_from_camera.translation());
    let axis = world_from_camera.rotation().column(2).into_owned();
    let mut near: Vec<(f64, KeyframeId)> = map
        .keyframes()
        .filter_map(|(id, keyframe)| {
            let distance = (keyframe.center_in_world() - center).norm();
            // Of a large map most are far away, and no more of them is looked at.
            Some((id, keyframe, distance)).filter(|_| distance < 0.5 * scene_depth)
        })
        .filter_map(|(id, keyframe, distance)| {
            let cos = keyframe.camera_from_world().rotation().row(2).transpose().dot(&axis);
            let is_wanted = cos > 0.8 && !listed.contains(&id);
            is_wanted.then_some((distance / scene_depth + 2.0 * (1.0 - cos), id))
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.into_iter().take(max).map(|(_, id)| id).collect()
}
