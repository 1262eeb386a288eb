//! What the reported pose of the camera lets it see.

use nalgebra::{Point2, Point3};
use visloc_core::{
    Frame,
    geom::{Horizon, Plane},
};

use super::Cause;

/// Places along each side of the image at which it is asked for the ground.
const PLACES: u32 = 5;
/// With less of the image below the horizon the camera looks up.
const MIN_GROUND_SHARE: f64 = 0.1;
/// If all ground in view is nearer, the camera looks down, meters.
const MIN_FAR_M: f64 = 0.75;
/// A camera lower than this is on the ground, meters.
const MIN_HEIGHT_M: f64 = 0.03;
/// Horizontal views that no usual camera has, degrees. The upper limit is for the focal length of a lens without distortion.
const VIEW_DEG: (f64, f64) = (10.0, 155.0);

/// Horizontal angle of view, degrees, by focal length and width alone.
pub(super) fn view_deg(frame: &Frame) -> f64 {
    let half_width_px = 0.5 * f64::from(frame.camera.size_px().0);
    2.0 * half_width_px.atan2(frame.camera.focal_px().0).to_degrees()
}

/// How far the camera looks below the horizontal, degrees.
pub(super) fn tilt_deg(frame: &Frame) -> f64 {
    let ahead = frame.robot_from_camera.rotation().column(2).into_owned();
    (-ahead.z).clamp(-1.0, 1.0).asin().to_degrees()
}

/// Where the camera looks, seen from the robot, radians to the left.
pub(super) fn pan_rad(frame: &Frame) -> f64 {
    let ahead = frame.robot_from_camera.rotation().column(2).into_owned();
    ahead.y.atan2(ahead.x)
}

/// What is wrong with what the camera is said to be.
pub(super) fn cause(frame: &Frame) -> Option<Cause> {
    if !(VIEW_DEG.0..VIEW_DEG.1).contains(&view_deg(frame)) {
        return Some(Cause::Calibration);
    }
    if frame.robot_from_camera.translation().z < MIN_HEIGHT_M {
        return Some(Cause::CameraOnGround);
    }
    let (ground_share, far_m) = ground(frame);
    if ground_share < MIN_GROUND_SHARE {
        return Some(Cause::CameraUp);
    }
    (far_m < MIN_FAR_M).then_some(Cause::CameraDown)
}

/// Share of the image below the horizon, and distance of the farthest ground in view, meters: infinite if the horizon is in
/// view.
fn ground(frame: &Frame) -> (f64, f64) {
    let horizon = Horizon::new(&frame.camera, &frame.robot_from_camera);
    let (width, height) = frame.camera.size_px();
    let eye = Point3::from(*frame.robot_from_camera.translation());
    let (mut num_ground, mut far_m) = (0_u32, 0.0_f64);
    for i in 0..PLACES * PLACES {
        let at = |index: u32, size: u32| {
            f64::from(size.saturating_sub(1)) * f64::from(index) / f64::from(PLACES - 1)
        };
        let px = Point2::new(at(i % PLACES, width), at(i / PLACES, height));
        let direction = frame.robot_from_camera.rotate(&frame.camera.bearing(&px));
        let point = Plane::ground().intersect_ray(&eye, &direction);
        let is_ground = !horizon.is_above(&frame.camera.ideal_px(&px));
        match point.filter(|_| is_ground) {
            Some(point) => {
                num_ground += 1;
                far_m = far_m.max(point.x.hypot(point.y));
            }
            None => far_m = f64::INFINITY,
        }
    }
    (f64::from(num_ground) / f64::from(PLACES * PLACES), far_m)
}
