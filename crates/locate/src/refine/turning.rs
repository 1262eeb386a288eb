//! How fast the camera turns: a turning camera blurs its image.

use nalgebra::Vector3;
use visloc_core::geom::angle;

use crate::{StepInput, vision::Percept};

/// Follows the direction of the camera.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Turning {
    /// Direction in the last image, seen from where the odometry began, radians.
    last_direction_rad: Option<f64>,
}

impl Turning {
    /// Turn rate of the camera since the last image, head and body together, radians per second; 0 if nobody can tell.
    pub fn rate_rad_per_s(&mut self, input: &StepInput<'_>, secs: f64) -> f64 {
        let odometry = input.odometry.filter(visloc_core::geom::PlanarPose::is_finite);
        let direction_rad = odometry.map(|odometry| odometry.yaw_rad + camera_yaw_rad(input.percept));
        let last = std::mem::replace(&mut self.last_direction_rad, direction_rad);
        match (last, direction_rad) {
            (Some(last), Some(now)) if secs > 0.0 => angle::difference(now, last).abs() / secs,
            _ => 0.0,
        }
    }
}

/// Direction in which the camera looks, in the robot's axes, radians.
pub(super) fn camera_yaw_rad(percept: &Percept) -> f64 {
    let ahead = percept.robot_from_camera.rotate(&Vector3::z());
    ahead.y.atan2(ahead.x)
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::{PlanarPose, nao};

    use super::*;

    #[test]
    fn head_and_body_turn_the_camera() {
        let mut turning = Turning::default();
        let mut rate = |body_rad: Option<f64>, head_rad: f64| {
            let head = nao::HeadAngles { yaw_rad: head_rad, pitch_rad: 0.0 };
            let robot_from_camera =
                nao::robot_from_camera(&nao::Torso::upright(), &head, nao::NaoCamera::TopV3);
            let percept = Percept { robot_from_camera, ..Percept::default() };
            let odometry = body_rad.map(|yaw_rad| PlanarPose::new(1.0, 2.0, yaw_rad));
            turning.rate_rad_per_s(&StepInput { percept: &percept, odometry, is_lifted: false }, 0.1)
        };
        assert_eq!(rate(Some(3.1), 0.0), 0.0, "nothing to compare with");
        assert!((rate(Some(-3.1), 0.0) - 0.832).abs() < 0.001, "the short way around");
        assert!((rate(Some(-3.0), 0.1) - 2.0).abs() < 1e-6, "both");
        assert!(rate(Some(-2.9), 0.0).abs() < 1e-6, "the head keeps still in the world");
        assert_eq!(rate(None, 0.3), 0.0, "without odometry nobody can tell");
    }
}
