//! The map as arrays of numbers.

use nalgebra::{Point2, Point3, Vector3};
use visloc_core::geom::{Camera, CameraFrame, Rigid3, World};
use visloc_slam::{
    Slam,
    map::{Keyframe, Landmark, Map},
    mapping::DepthFilter,
};

use super::display::Display;

/// Landmarks that a page is shown.
const MAX_LANDMARKS: usize = 8000;
/// Keyframes that share fewer landmarks are not linked.
const MIN_SHARED: u32 = 40;
/// Ends of a candidate's depth are drawn at most so many times nearer or farther than its mean.
const MAX_STRETCH: f64 = 1.5;
/// A landmark that is found lies within so many pixels of its projection.
const FOUND_PX: f64 = 4.0;

/// Places of all converged landmarks.
pub(super) fn landmarks(map: &Map, display: &Display) -> Vec<f64> {
    let converged: Vec<&Landmark> =
        map.landmarks().map(|(_, landmark)| landmark).filter(|landmark| landmark.is_converged()).collect();
    let every = converged.len().div_ceil(MAX_LANDMARKS).max(1);
    converged
        .iter()
        .step_by(every)
        .flat_map(|landmark| xyz(&display.point(&landmark.point_in_world)))
        .collect()
}

/// Near and far end of every candidate's depth, two standard deviations to both sides.
pub(super) fn candidates(map: &Map, display: &Display) -> Vec<f64> {
    let uncertain = map.landmarks().filter_map(|(_, landmark)| Some((landmark, landmark.filter.as_deref()?)));
    let ends = |(landmark, filter): (&Landmark, &DepthFilter)| {
        let host = landmark.host();
        let world_from_camera = map.keyframe(host.keyframe).camera_from_world().inverse();
        let (least, most) = filter.interval();
        let mean = filter.inverse_depth();
        let (least, most) = (least.max(mean / MAX_STRETCH), most.min(mean * MAX_STRETCH));
        [most, least].map(|inverse_depth| {
            let in_camera = Point3::from(host.ray / inverse_depth);
            xyz(&display.point(&world_from_camera.transform(&in_camera)))
        })
    };
    uncertain.take(MAX_LANDMARKS).flat_map(ends).flatten().collect()
}

/// Place, and unit vectors to the right, down and ahead, of every keyframe.
pub(super) fn keyframes(map: &Map, display: &Display) -> Vec<f64> {
    let pose = |keyframe: &Keyframe| camera_axes(&keyframe.camera_from_world().inverse(), display);
    map.keyframes().flat_map(|(_, keyframe)| pose(keyframe)).collect()
}

/// Both ends of every link between keyframes that see the same.
pub(super) fn links(map: &Map, display: &Display) -> Vec<f64> {
    let mut out = Vec::new();
    for (id, keyframe) in map.keyframes() {
        for (other, _) in map.connected(id, MIN_SHARED) {
            if other < id {
                out.extend(xyz(&display.point(keyframe.center_in_world())));
                out.extend(xyz(&display.point(map.keyframe(other).center_in_world())));
            }
        }
    }
    out
}

/// Place and axes of a camera.
pub(super) fn camera_axes(world_from_camera: &Rigid3<World, CameraFrame>, display: &Display) -> Vec<f64> {
    let place = display.point(&Point3::from(*world_from_camera.translation()));
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let axes = axes.map(|axis| display.direction(&world_from_camera.rotate(&axis)));
    xyz(&place).into_iter().chain(axes.into_iter().flat_map(|axis| [axis.x, axis.y, axis.z])).collect()
}

/// The camera's way.
pub(super) fn trajectory(slam: &Slam, display: &Display) -> Vec<f64> {
    let place = |pose: visloc_slam::TrajectoryPose| Point3::from(*pose.world_from_camera.translation());
    slam.trajectory().into_iter().flat_map(|pose| xyz(&display.point(&place(pose)))).collect()
}

/// Pixels where landmarks should be seen and none was found.
pub(super) fn missed(
    map: &Map,
    camera: &Camera,
    camera_from_world: &Rigid3<CameraFrame, World>,
    found: &[(Point2<f64>, bool)],
) -> Vec<f64> {
    let is_found = |px: &Point2<f64>| found.iter().any(|(other, _)| (other - px).norm() < FOUND_PX);
    let converged = map.landmarks().filter(|(_, landmark)| landmark.is_converged());
    let seen = converged.filter_map(|(_, landmark)| {
        let in_camera = camera_from_world.transform(&landmark.point_in_world);
        camera.project(&in_camera).ok().filter(|px| in_camera.z > 0.0 && camera.contains(px))
    });
    seen.take(MAX_LANDMARKS / 4).filter(|px| !is_found(px)).flat_map(|px| [px.x, px.y]).collect()
}

pub(super) fn xyz(point: &Point3<f64>) -> [f64; 3] {
    [point.x, point.y, point.z]
}
