//! How a camera stood over the ground.

use serde::Serialize;
use visloc_locate::PhotoPose;

/// Place of the camera over the ground, the direction in which it looked, and how it was held: meters, degrees.
#[derive(Serialize)]
pub struct GroundPose {
    x_m: f64,
    y_m: f64,
    yaw_deg: f64,
    height_m: f64,
    /// Down is positive.
    pitch_deg: f64,
    /// Clockwise is positive.
    roll_deg: f64,
}

impl From<&PhotoPose> for GroundPose {
    fn from(pose: &PhotoPose) -> Self {
        Self {
            x_m: pose.world_from_view.x_m,
            y_m: pose.world_from_view.y_m,
            yaw_deg: pose.world_from_view.yaw_rad.to_degrees(),
            height_m: pose.height_m,
            pitch_deg: pose.pitch_down_rad.to_degrees(),
            roll_deg: pose.roll_clockwise_rad.to_degrees(),
        }
    }
}

/// Where the camera was and how it was held.
pub fn pose_in_words(pose: &PhotoPose) -> String {
    let view = &pose.world_from_view;
    format!(
        "x {:.2} m, y {:.2} m, looking to {:.0} deg; {:.2} m high, {:.1} deg {}, rolled by {:.1} deg",
        view.x_m,
        view.y_m,
        view.yaw_rad.to_degrees(),
        pose.height_m,
        pose.pitch_down_rad.to_degrees().abs(),
        if pose.pitch_down_rad < 0.0 { "up" } else { "down" },
        pose.roll_clockwise_rad.to_degrees()
    )
}
