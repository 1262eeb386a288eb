//! A straight border in space, and how far a pixel lies from its image.

use nalgebra::{Matrix3, Point2, Point3, Vector2, Vector3};

use super::features::{CameraState, CameraVector, Residual, small_rotation};

/// The camera of one state in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eye {
    /// Where it is, meters.
    pub at: Point3<f64>,
    /// From the robot's foot to the eye, in the world's axes, meters.
    pub lever: Vector3<f64>,
    /// Its axes.
    pub world_from_camera: Matrix3<f64>,
}

/// A straight border in space: a point on it and its direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub point: Point3<f64>,
    pub along: Vector3<f64>,
}

impl Eye {
    /// The camera of a state, given its place on the robot.
    pub fn new(state: &CameraState, robot_from_camera: &Matrix3<f64>, eye_in_robot: &Vector3<f64>) -> Self {
        let (sin, cos) = state.world_from_robot.yaw_rad.sin_cos();
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let lever = turn * (eye_in_robot + Vector3::z() * state.raise_m);
        Self {
            at: Point3::new(state.world_from_robot.x_m, state.world_from_robot.y_m, 0.0) + lever,
            lever,
            world_from_camera: turn * robot_from_camera * small_rotation(&state.tilt_rad),
        }
    }

    /// The direction of a pixel, given as a direction in the camera frame with z = 1.
    #[inline]
    pub fn ray(&self, in_camera: &Vector3<f64>) -> Ray {
        Ray { in_camera: *in_camera, in_world: self.world_from_camera * in_camera }
    }

    /// Where a ray meets the ground.
    #[inline]
    pub fn ground(&self, ray: &Ray) -> Option<Point2<f64>> {
        let along = &ray.in_world;
        (along.z < 0.0).then(|| (self.at + along * (-self.at.z / along.z)).xy())
    }

    /// The image of an edge.
    #[inline]
    pub fn image_of(&self, edge: &Edge, focal_px: (f64, f64)) -> EdgeImage {
        let plane = edge.along.cross(&(edge.point - self.at));
        let plane_in_camera = self.world_from_camera.tr_mul(&plane);
        let line = Vector2::new(plane_in_camera.x / focal_px.0, plane_in_camera.y / focal_px.1);
        EdgeImage { along: edge.along, plane, plane_in_camera, line }
    }

    /// The distance with its derivative.
    pub fn residual(&self, ray: &Ray, offset: &Offset) -> Residual {
        let EdgeImage { along, plane, plane_in_camera, .. } = &offset.image;
        let in_world = &ray.in_world;
        let by_eye = along.cross(in_world);
        let by_heading =
            by_eye.y * self.lever.x - by_eye.x * self.lever.y + plane.y * in_world.x - plane.x * in_world.y;
        let by_tilt = ray.in_camera.cross(plane_in_camera);
        let jacobian =
            CameraVector::from([by_eye.x, by_eye.y, by_heading, by_tilt.x, by_tilt.y, by_tilt.z, by_eye.z])
                / offset.scale;
        Residual { error_px: offset.error_px, jacobian }
    }
}

/// The direction of a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    /// In the camera frame, with z = 1.
    in_camera: Vector3<f64>,
    /// In the world's axes.
    pub in_world: Vector3<f64>,
}

/// Where an edge is in the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeImage {
    along: Vector3<f64>,
    /// Normal of the plane through the eye and the edge.
    pub plane: Vector3<f64>,
    plane_in_camera: Vector3<f64>,
    /// Normal of the edge's image, not of unit length.
    pub line: Vector2<f64>,
}

impl EdgeImage {
    /// Where a pixel lies beside it; `None` for an edge that points at the eye.
    #[inline]
    pub fn offset(self, ray: &Ray) -> Option<Offset> {
        let scale = self.line.norm();
        let is_seen = scale >= 1e-9;
        is_seen.then(|| Offset { error_px: self.plane.dot(&ray.in_world) / scale, image: self, scale })
    }
}

/// Where a pixel lies beside the image of an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Offset {
    /// Signed distance, pixels.
    pub error_px: f64,
    image: EdgeImage,
    scale: f64,
}
