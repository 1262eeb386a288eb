//! The horizon line of a camera.

use nalgebra::{Point2, Vector3};

use crate::geom::{Camera, CameraFrame, Rigid3};

/// The line of the image on which the ground plane vanishes, in undistorted ("ideal") pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horizon {
    /// `line . (u, v, 1) = 0` on the horizon, positive above it (sky), negative below it (ground).
    line: Vector3<f64>,
}

impl Horizon {
    /// Horizon of a camera whose pose relative to a frame with z up is known (robot or world).
    pub fn new<Upright>(camera: &Camera, upright_from_camera: &Rigid3<Upright, CameraFrame>) -> Self {
        let up_in_camera = upright_from_camera.rotation().row(2).transpose();
        let (fx, fy) = camera.focal_px();
        let (cx, cy) = camera.center_px();
        let (a, b) = (up_in_camera.x / fx, up_in_camera.y / fy);
        Self { line: Vector3::new(a, b, up_in_camera.z - a * cx - b * cy) }
    }

    /// Whether an undistorted pixel looks above the horizon.
    #[inline]
    pub fn is_above(&self, ideal_px: &Point2<f64>) -> bool {
        self.line.x * ideal_px.x + self.line.y * ideal_px.y + self.line.z > 0.0
    }

    /// Row of the horizon in a column, undistorted pixels; `None` if the horizon is vertical.
    pub fn row_px(&self, column_px: f64) -> Option<f64> {
        (self.line.y.abs() > 1e-12).then(|| -(self.line.x * column_px + self.line.z) / self.line.y)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::geom::{Plane, Robot, nao};

    #[test]
    fn pixels_below_the_horizon_meet_the_ground() {
        let camera = Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 119.5)).unwrap();
        for (pitch, roll) in [(0.0, 0.0), (0.3, 0.1), (-0.2, -0.15)] {
            let torso = nao::Torso { height_m: 0.333, roll_rad: roll, pitch_rad: 0.0 };
            let head = nao::HeadAngles { yaw_rad: 0.4, pitch_rad: pitch };
            let robot_from_camera = nao::robot_from_camera(&torso, &head, nao::NaoCamera::TopV4);
            let horizon = Horizon::new::<Robot>(&camera, &robot_from_camera);
            let eye = Point3::from(*robot_from_camera.translation());
            for v in (0..240).step_by(7) {
                for u in (0..320).step_by(11) {
                    let px = Point2::new(f64::from(u), f64::from(v));
                    let direction = robot_from_camera.rotate(&camera.bearing(&px));
                    let meets = Plane::ground().intersect_ray(&eye, &direction).is_some();
                    assert_eq!(meets, !horizon.is_above(&px), "pixel {u} {v}");
                }
            }
        }
    }
}
