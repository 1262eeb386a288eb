//! Head kinematics of the Nao: from torso attitude and neck angles to the pose of either camera.
//!
//! Source of the numbers: Aldebaran, Nao documentation, "H25 - Links - V3.3" (neck, leg and foot lengths) and
//! "Video camera" (camera positions and pitch of heads V3 and V4); chain as in the master's thesis of 2010, equation 3.1.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::geom::{CameraFrame, Rigid3, Robot};

/// Height of the neck joint above the torso's center, meters (`NeckOffsetZ`).
pub const NECK_OFFSET_Z_M: f64 = 0.1265;
/// Torso center to hip, hip to knee, knee to ankle, ankle to sole, meters
/// (`HipOffsetZ`, `ThighLength`, `TibiaLength`, `FootHeight`).
pub const LEG_LENGTHS_M: [f64; 4] = [0.085, 0.100, 0.1029, 0.04519];

/// The cameras of the robot's two head generations. They sit above each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NaoCamera {
    /// Head V3 (the robot of the documents), in the forehead, looking ahead.
    TopV3,
    /// Head V3, in the mouth, looking down; the one that the documents use.
    BottomV3,
    /// Head V4 and later, in the forehead.
    TopV4,
    /// Head V4 and later, in the mouth.
    BottomV4,
}

impl NaoCamera {
    /// Position relative to the neck joint with the head straight (x forward, z up), meters.
    pub fn offset_m(self) -> Vector3<f64> {
        match self {
            Self::TopV3 => Vector3::new(0.0539, 0.0, 0.0679),
            Self::BottomV3 => Vector3::new(0.0488, 0.0, 0.02381),
            Self::TopV4 => Vector3::new(0.05871, 0.0, 0.06364),
            Self::BottomV4 => Vector3::new(0.05071, 0.0, 0.01774),
        }
    }

    /// Downward tilt of the optical axis relative to the head, radians.
    pub fn pitch_rad(self) -> f64 {
        match self {
            Self::TopV3 => 0.0,
            Self::BottomV3 => 0.6981,
            Self::TopV4 => 0.0209,
            Self::BottomV4 => 0.6929,
        }
    }
}

/// Attitude of the torso above the robot's footprint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Torso {
    /// Height of the torso's center above the ground, meters.
    pub height_m: f64,
    /// Rotation about the forward axis, radians.
    pub roll_rad: f64,
    /// Rotation about the left axis, radians; positive leans forward.
    pub pitch_rad: f64,
}

impl Torso {
    /// Standing upright with straight legs.
    pub fn upright() -> Self {
        Self { height_m: LEG_LENGTHS_M.iter().sum(), roll_rad: 0.0, pitch_rad: 0.0 }
    }
}

/// Angles of the neck joints.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeadAngles {
    /// Pan, radians; positive turns to the left.
    pub yaw_rad: f64,
    /// Tilt, radians; positive looks down.
    pub pitch_rad: f64,
}

/// Pose of a camera relative to the footprint: torso, then neck yaw, neck pitch, camera mount.
pub fn robot_from_camera(torso: &Torso, head: &HeadAngles, camera: NaoCamera) -> Rigid3<Robot, CameraFrame> {
    let robot_from_torso = Rotation3::from_euler_angles(torso.roll_rad, torso.pitch_rad, 0.0);
    let torso_from_head = Rotation3::from_euler_angles(0.0, head.pitch_rad, head.yaw_rad);
    let head_from_mount = Rotation3::from_euler_angles(0.0, camera.pitch_rad(), 0.0);
    let translation = Vector3::new(0.0, 0.0, torso.height_m)
        + robot_from_torso * (Vector3::new(0.0, 0.0, NECK_OFFSET_Z_M) + torso_from_head * camera.offset_m());
    let rotation = robot_from_torso * torso_from_head * head_from_mount * body_from_optical();
    Rigid3::new(rotation, translation)
}

/// Rotation from optical axes (x right, y down, z forward) to body axes (x forward, y left, z up).
pub fn body_from_optical() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_head_by_hand() {
        let pose = robot_from_camera(&Torso::upright(), &HeadAngles::default(), NaoCamera::TopV4);
        // 0.33309 standing + 0.1265 neck + 0.06364 camera
        assert!((pose.translation() - Vector3::new(0.05871, 0.0, 0.52323)).norm() < 1e-9);
        let axis = pose.rotate(&Vector3::z());
        assert!((axis - Vector3::new(0.0209_f64.cos(), 0.0, -(0.0209_f64.sin()))).norm() < 1e-9);
    }

    #[test]
    fn looking_left_moves_the_camera_left_and_turns_the_axis() {
        let head = HeadAngles { yaw_rad: std::f64::consts::FRAC_PI_2, pitch_rad: 0.0 };
        let pose = robot_from_camera(&Torso::upright(), &head, NaoCamera::BottomV4);
        assert!((pose.translation() - Vector3::new(0.0, 0.05071, 0.33309 + 0.1265 + 0.01774)).norm() < 1e-9);
        let axis = pose.rotate(&Vector3::z());
        assert!(axis.x.abs() < 1e-9 && axis.y > 0.7 && axis.z < -0.6);
        // the image's right is the robot's front when it looks left
        assert!((pose.rotate(&Vector3::x()) - Vector3::x()).norm() < 1e-9);
    }

    #[test]
    fn pitching_down_lowers_the_gaze() {
        let down = HeadAngles { yaw_rad: 0.3, pitch_rad: 0.4 };
        let level = HeadAngles { yaw_rad: 0.3, pitch_rad: 0.0 };
        let gaze_z =
            |head| robot_from_camera(&Torso::upright(), &head, NaoCamera::TopV4).rotate(&Vector3::z()).z;
        assert!(gaze_z(down) < gaze_z(level));
    }
}
