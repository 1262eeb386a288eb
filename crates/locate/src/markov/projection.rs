//! What a camera sees of a goal from a pose: visible area and middle, for thousands of poses.

use nalgebra::{Matrix3x4, Point2, Vector3};
use visloc_core::geom::PlanarPose;

use crate::{
    observation::{Landmark, projection::projection},
    vision::Percept,
};

/// Area and middle of what is visible of a landmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct VisiblePart {
    /// Pixels.
    pub area_px: f64,
    /// Column of the middle, pixels without distortion.
    pub column_px: f64,
}

/// The camera of one percept.
#[derive(Debug, Clone)]
pub(super) struct CameraView {
    /// Undistorted pixel (homogeneous) of a point in the robot's frame.
    ideal_from_robot: Matrix3x4<f64>,
    focal_px: f64,
    size_px: (f64, f64),
}

/// Nearest depth that is projected, meters.
const NEAR_M: f64 = 0.15;

impl CameraView {
    pub fn new(percept: &Percept) -> Self {
        let camera = &percept.camera;
        let (width, height) = camera.size_px();
        Self {
            ideal_from_robot: projection(camera, &percept.robot_from_camera),
            focal_px: camera.focal_px().0,
            size_px: (f64::from(width), f64::from(height)),
        }
    }

    /// Pixels to radians near the image's middle.
    pub fn focal_px(&self) -> f64 {
        self.focal_px
    }

    /// What is visible of a landmark from a pose; nothing if it is out of view. Posts and bar are taken for straight
    /// bands as wide as their thickness.
    pub fn visible(&self, robot_from_world: &RobotFromWorld, landmark: &Landmark) -> Option<VisiblePart> {
        let [left, right] = landmark.ends.map(|end| robot_from_world.transform(&end));
        let bottom = |p: &Point2<f64>| self.homogeneous(p, 0.0);
        let top = |p: &Point2<f64>| self.homogeneous(p, landmark.height_m);
        let (top_left, top_right) = (top(&left), top(&right));
        let thickness_m = 2.0 * landmark.radius_m;
        let (mut area, mut moment) = (0.0, 0.0);
        for (from, to) in [(bottom(&left), top_left), (bottom(&right), top_right), (top_left, top_right)] {
            if let Some(part) = self.band(from, to, thickness_m) {
                area += part.area_px;
                moment += part.area_px * part.column_px;
            }
        }
        (area > 0.0).then(|| VisiblePart { area_px: area, column_px: moment / area })
    }

    fn homogeneous(&self, ground_in_robot: &Point2<f64>, z_m: f64) -> Vector3<f64> {
        let m = &self.ideal_from_robot;
        let row = |r: usize| {
            m[(r, 0)] * ground_in_robot.x + m[(r, 1)] * ground_in_robot.y + m[(r, 2)] * z_m + m[(r, 3)]
        };
        Vector3::new(row(0), row(1), row(2))
    }

    /// The visible part of a straight band between two homogeneous pixels.
    fn band(&self, from: Vector3<f64>, to: Vector3<f64>, thickness_m: f64) -> Option<VisiblePart> {
        let (from, to) = clip_near(from, to)?;
        let pixel = |p: &Vector3<f64>| (p.x / p.z, p.y / p.z);
        let ((u0, v0), (u1, v1)) = (pixel(&from), pixel(&to));
        let (width, height) = self.size_px;
        let (mut enter, mut leave) = (0.0, 1.0);
        for (start, delta, size) in [(u0, u1 - u0, width), (v0, v1 - v0, height)] {
            clip(start, delta, size, &mut enter, &mut leave);
        }
        if leave <= enter {
            return None;
        }
        let middle = f64::midpoint(enter, leave);
        // Depth along a band is linear in the image only by its inverse.
        let inverse_depth = 1.0 / from.z + middle * (1.0 / to.z - 1.0 / from.z);
        let length_px = (u1 - u0).hypot(v1 - v0) * (leave - enter);
        let area_px = length_px * thickness_m * self.focal_px * inverse_depth;
        Some(VisiblePart { area_px, column_px: u0 + middle * (u1 - u0) })
    }
}

/// Cuts a segment off in front of the camera.
fn clip_near(from: Vector3<f64>, to: Vector3<f64>) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let cut = |behind: Vector3<f64>, ahead: Vector3<f64>| {
        behind + (ahead - behind) * ((NEAR_M - behind.z) / (ahead.z - behind.z))
    };
    match (from.z >= NEAR_M, to.z >= NEAR_M) {
        (true, true) => Some((from, to)),
        (true, false) => Some((from, cut(to, from))),
        (false, true) => Some((cut(from, to), to)),
        (false, false) => None,
    }
}

/// Narrows the visible range of a segment to one dimension of the image. Source: Liang and Barsky, 1984.
fn clip(start: f64, delta: f64, size: f64, enter: &mut f64, leave: &mut f64) {
    if delta.abs() < 1e-9 {
        if !(0.0..=size).contains(&start) {
            *leave = -1.0;
        }
        return;
    }
    let (a, b) = (-start / delta, (size - start) / delta);
    *enter = enter.max(a.min(b));
    *leave = leave.min(a.max(b));
}

/// A pose prepared for many points.
#[derive(Debug, Clone, Copy)]
pub(super) struct RobotFromWorld {
    position: Point2<f64>,
    sine: f64,
    cosine: f64,
}

impl RobotFromWorld {
    pub fn new(world_from_robot: &PlanarPose) -> Self {
        let (sine, cosine) = world_from_robot.yaw_rad.sin_cos();
        Self { position: world_from_robot.position(), sine, cosine }
    }

    fn transform(&self, point: &Point2<f64>) -> Point2<f64> {
        let d = point - self.position;
        Point2::new(self.cosine * d.x + self.sine * d.y, self.cosine * d.y - self.sine * d.x)
    }
}
