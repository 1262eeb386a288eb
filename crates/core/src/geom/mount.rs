//! A camera that is fixed on the robot.

use nalgebra::{Rotation3, Vector3};

use super::{CameraFrame, Rigid3, Robot, nao};

/// Where a camera is on the robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mount {
    /// Above the ground, meters.
    pub height_m: f64,
    /// Ahead of the robot's middle, meters.
    pub forward_m: f64,
    /// Downward tilt of the optical axis, radians.
    pub tilt_rad: f64,
    /// To the left, radians.
    pub pan_rad: f64,
    /// About the optical axis: the image's content turns left, radians.
    pub roll_rad: f64,
}

impl Mount {
    /// The camera's pose on the robot.
    pub fn robot_from_camera(&self) -> Rigid3<Robot, CameraFrame> {
        let pan = Rotation3::from_axis_angle(&Vector3::z_axis(), self.pan_rad);
        let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), self.tilt_rad);
        let roll = Rotation3::from_axis_angle(&Vector3::x_axis(), self.roll_rad);
        let rotation = pan * tilt * roll * nao::body_from_optical();
        Rigid3::new(rotation, Vector3::new(self.forward_m, 0.0, self.height_m))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn the_optical_axis_points_where_the_angles_say() {
        let ahead = Vector3::z();
        let axis = |mount: Mount| mount.robot_from_camera().rotate(&ahead);
        assert!((axis(Mount::default()) - Vector3::x()).norm() < 1e-12);
        assert!((axis(Mount { tilt_rad: FRAC_PI_2, ..Mount::default() }) + Vector3::z()).norm() < 1e-12);
        assert!((axis(Mount { pan_rad: FRAC_PI_2, ..Mount::default() }) - Vector3::y()).norm() < 1e-12);
        let rolled = Mount { roll_rad: 0.3, ..Mount::default() };
        assert!((axis(rolled) - Vector3::x()).norm() < 1e-12);
    }
}
