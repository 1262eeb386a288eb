//! A straight border in space, and how far a pixel lies from its image.

use nalgebra::{Matrix3, Point3, Vector2, Vector3};

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

    /// Signed distance of a pixel from the image of an edge; also the unit normal of that image. The pixel is a direction
    /// in the camera frame with z = 1.
    pub fn residual(
        &self,
        ray_in_camera: &Vector3<f64>,
        edge: &Edge,
        focal_px: (f64, f64),
    ) -> Option<(Residual, Vector2<f64>)> {
        // The plane through the eye and the edge.
        let plane = edge.along.cross(&(edge.point - self.at));
        let plane_in_camera = self.world_from_camera.tr_mul(&plane);
        let line = Vector2::new(plane_in_camera.x / focal_px.0, plane_in_camera.y / focal_px.1);
        let scale = line.norm();
        if scale < 1e-9 {
            return None;
        }
        let ray = self.world_from_camera * ray_in_camera;
        let by_eye = edge.along.cross(&ray);
        let by_heading =
            by_eye.y * self.lever.x - by_eye.x * self.lever.y + plane.y * ray.x - plane.x * ray.y;
        let by_tilt = ray_in_camera.cross(&plane_in_camera);
        let jacobian =
            CameraVector::from([by_eye.x, by_eye.y, by_heading, by_tilt.x, by_tilt.y, by_tilt.z, by_eye.z])
                / scale;
        Some((Residual { error_px: plane.dot(&ray) / scale, jacobian }, line / scale))
    }
}
