//! Projection into the image, and what the distances in it say together.

use nalgebra::{Matrix3, Matrix3x4};
use visloc_core::geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot};

/// Likelihood from the sums of pixel distances of two kinds of features, for instance lines and goals (2010 equations 4.1 and 4.2).
pub(crate) fn combine(max_distance_px: f64, first: (f64, usize), second: (f64, usize)) -> f64 {
    let of = |(sum, count): (f64, usize)| (1.0 - sum / (count as f64 * max_distance_px)).max(0.0);
    match (first.1, second.1) {
        (0, 0) => 0.0,
        (_, 0) => of(first),
        (0, _) => of(second),
        _ => 0.5 * (of(first) + of(second)),
    }
}

/// Projection of points of the robot frame to homogeneous undistorted pixels.
pub(crate) fn projection(camera: &Camera, robot_from_camera: &Rigid3<Robot, CameraFrame>) -> Matrix3x4<f64> {
    let camera_from_robot = robot_from_camera.inverse();
    let ((fx, fy), (cx, cy)) = (camera.focal_px(), camera.center_px());
    let intrinsics = Matrix3::new(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0);
    let mut pose = Matrix3x4::zeros();
    pose.fixed_view_mut::<3, 3>(0, 0).copy_from(camera_from_robot.rotation());
    pose.set_column(3, camera_from_robot.translation());
    intrinsics * pose
}

/// Projection of points of the world, for a robot at a pose with this sine and cosine of its heading, from that of points of the robot frame.
#[inline]
pub(crate) fn ideal_from_world_at(
    pose: &PlanarPose,
    (sin, cos): (f64, f64),
    ideal_from_robot: &Matrix3x4<f64>,
) -> Matrix3x4<f64> {
    let mut ideal_from_world = *ideal_from_robot;
    for r in 0..3 {
        let (a, b) = (ideal_from_robot[(r, 0)], ideal_from_robot[(r, 1)]);
        let (turned_a, turned_b) = (a * cos - b * sin, a * sin + b * cos);
        ideal_from_world[(r, 0)] = turned_a;
        ideal_from_world[(r, 1)] = turned_b;
        ideal_from_world[(r, 3)] -= turned_a * pose.x_m + turned_b * pose.y_m;
    }
    ideal_from_world
}
