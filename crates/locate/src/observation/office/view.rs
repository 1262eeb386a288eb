//! Theoretical lines in the image of one pose.

use nalgebra::{Matrix3, Matrix3x4, Point2, Point3, RowVector4, Vector2};
use visloc_core::geom::PlanarPose;

use super::lines::TheoreticalLine;
use crate::observation::{edge::Eye, projection::ideal_from_world_at};

/// What is nearer to the camera's plane than this is cut off, meters.
const NEAR_M: f64 = 0.05;

/// What is seen from a pose: worked out once for each pose, used for each line.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub eye: Point2<f64>,
    /// Projection of points of the world to homogeneous undistorted pixels.
    ideal_from_world: Matrix3x4<f64>,
}

impl View {
    #[inline]
    pub fn new(pose: &PlanarPose, ideal_from_robot: &Matrix3x4<f64>, eye_in_robot: &Point3<f64>) -> Self {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let (x, y) = (pose.x_m, pose.y_m);
        let eye = Vector2::new(
            cos * eye_in_robot.x - sin * eye_in_robot.y,
            sin * eye_in_robot.x + cos * eye_in_robot.y,
        );
        let ideal_from_world = ideal_from_world_at(pose, (sin, cos), ideal_from_robot);
        Self { eye: Point2::new(x, y) + eye, ideal_from_world }
    }

    /// What the camera of a state sees, its tilt included.
    #[inline]
    pub fn tilted(eye: &Eye, intrinsics: &Matrix3<f64>) -> Self {
        let turn = intrinsics * eye.world_from_camera.transpose();
        let mut ideal_from_world = turn.insert_column(3, 0.0);
        ideal_from_world.set_column(3, &(turn * -eye.at.coords));
        Self { eye: eye.at.xy(), ideal_from_world }
    }

    /// A row of the projection of homogeneous points of the world.
    #[inline]
    pub fn row(&self, row: usize) -> RowVector4<f64> {
        self.ideal_from_world.row(row).into_owned()
    }

    /// Both ends of a line in undistorted pixels, the part behind the camera cut off; `None` if all of it is.
    #[inline]
    pub fn project(&self, line: &TheoreticalLine) -> Option<[Point2<f64>; 2]> {
        let p = &self.ideal_from_world;
        let row = |r: usize, at: &Point2<f64>, z: f64| {
            p[(r, 0)] * at.x + p[(r, 1)] * at.y + p[(r, 2)] * z + p[(r, 3)]
        };
        let start_w = row(2, &line.start, 0.0);
        let end_w = row(2, &line.end, line.end_height_m);
        if start_w < NEAR_M && end_w < NEAR_M {
            return None;
        }
        let start = [row(0, &line.start, 0.0), row(1, &line.start, 0.0), start_w];
        let end = [row(0, &line.end, line.end_height_m), row(1, &line.end, line.end_height_m), end_w];
        let start_cut = if start_w < NEAR_M { cut(&end, &start) } else { start };
        let end_cut = if end_w < NEAR_M { cut(&start, &end) } else { end };
        let pixel = |h: &[f64; 3]| Point2::new(h[0] / h[2], h[1] / h[2]);
        Some([pixel(&start_cut), pixel(&end_cut)])
    }
}

/// The point between one that lies ahead and one that does not, on the near plane.
#[inline]
fn cut(ahead: &[f64; 3], behind: &[f64; 3]) -> [f64; 3] {
    let t = (ahead[2] - NEAR_M) / (ahead[2] - behind[2]);
    [0, 1, 2].map(|i| ahead[i] + t * (behind[i] - ahead[i]))
}
