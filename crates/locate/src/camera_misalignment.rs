//! What a localizer has found out about the camera.

use serde::Serialize;

/// A constant error of the camera's direction, as a robot has it whose camera is bolted on wrong: where it really looks, seen from what
/// the robot reports.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CameraMisalignment {
    /// It looks so much farther down.
    pub pitch_down_deg: Uncertain,
    /// It is turned clockwise about its axis by so much more: the right side of the image is lower.
    pub roll_clockwise_deg: Uncertain,
    /// It looks so much farther to the left. Hardly ever told apart from the heading of the robot.
    pub yaw_left_deg: Uncertain,
    /// Whether a place that was relied upon has shown it; else it is that of the most probable place.
    pub is_confirmed: bool,
}

/// A value with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Uncertain {
    /// The value.
    pub mean: f64,
    /// Its standard deviation.
    pub sigma: f64,
}
