//! Taking maps to other frames, and the frame of one that was made on a robot: z up, as its odometry knows it.

use nalgebra::{Matrix3, Rotation3, Vector3};
use visloc_slam::{
    atlas::Similarity,
    map::{Correction, Keyframe, Map, MapId},
};

/// Takes a map in meters to the frame of the odometry that it was made with: its first keyframe is where the odometry had it, the vertical and the
/// height are those of all keyframes, since odometry drifts along the ground only. `None` without odometry.
pub(crate) fn odom_from_map(map: &Map, of: MapId) -> Option<Similarity> {
    let keyframes = || {
        let of_map = map.all_keyframes().map(|(_, keyframe)| keyframe).filter(move |k| k.map == of);
        of_map.filter_map(|k| Some((k, k.odometry?.odom_from_camera)))
    };
    let turn = |keyframe: &Keyframe, odom_from_camera: &Matrix3<f64>| {
        odom_from_camera * keyframe.camera_from_world().rotation()
    };
    let (first, odom_from_first) = keyframes().next()?;
    let up = keyframes().map(|(k, pose)| turn(k, pose.rotation()).transpose() * Vector3::z());
    let up_in_map = up.sum::<Vector3<f64>>();
    let first_turn = turn(first, odom_from_first.rotation());
    let correction = Rotation3::rotation_between(&(first_turn * up_in_map), &Vector3::z())?;
    let rotation = correction.matrix() * first_turn;
    let mut translation = odom_from_first.translation() - rotation * first.center_in_world().coords;
    let heights =
        || keyframes().map(|(k, pose)| pose.translation().z - (rotation * k.center_in_world().coords).z);
    translation.z = heights().sum::<f64>() / heights().count() as f64;
    Some(Similarity { scale: 1.0, rotation, translation })
}

/// Takes the keyframes and landmarks of one map to another frame and unit of length.
pub(crate) fn move_map(map: &mut Map, of: MapId, similarity: &Similarity) {
    let of_map = map.all_keyframes().filter(|(_, keyframe)| keyframe.map == of);
    let corrections: Vec<Correction> = of_map
        .map(|(keyframe, k)| Correction {
            keyframe,
            camera_from_world: similarity.pose(k.camera_from_world()),
            scale: similarity.scale,
        })
        .collect();
    map.correct(&corrections);
}
