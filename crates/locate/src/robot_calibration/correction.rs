//! Corrections of what a robot reports.

use nalgebra::{Rotation3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::{
    geom::{CameraFrame, PlanarPose, Rigid3, Robot},
    settings::check_ranges,
};

use crate::{ConfigError, require};

/// What to change of what a robot reports. A file names only what differs from nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RobotCorrection {
    /// Of the camera's pose on the robot.
    pub camera: MountCorrection,
    /// Of the odometry.
    pub odometry: OdometryCorrection,
}

/// Where the camera really is, seen from where the robot reports it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MountCorrection {
    /// It looks so much farther down, degrees.
    #[schemars(range(min = -45.0, max = 45.0))]
    pub pitch_down_deg: f64,
    /// It is turned clockwise about its axis by so much more, degrees: the right side of the image is lower.
    #[schemars(range(min = -45.0, max = 45.0))]
    pub roll_clockwise_deg: f64,
    /// It is so much higher, meters.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub height_m: f64,
}

visloc_core::with_defaults! {
    /// How the reported odometry becomes the real motion.
    /// By default nothing changes.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct OdometryCorrection {
        /// Factors of the reported motion ahead, to the left, and of the reported turn.
        pub scale: [f64; 3] = [1.0; 3],
        /// Turn to the left for each reported meter that the odometry does not know of, degrees.
        #[schemars(range(min = -360.0, max = 360.0))]
        pub drift_deg_per_m: f64 = 0.0,
    }
}

impl RobotCorrection {
    /// Whether all values are numbers that a robot can have.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        let is_possible = |factor: &f64| (0.1..=10.0).contains(factor);
        let scale = self.odometry.scale;
        require(
            scale.iter().all(is_possible),
            "odometry.scale",
            "factors from 0.1 to 10",
            format!("{scale:?}"),
        )
    }
}

impl MountCorrection {
    /// From a rotation vector in the camera frame (only x and z are used), radians, and a height, meters.
    pub(super) fn from_tilt(tilt_x_rad: f64, tilt_z_rad: f64, height_m: f64) -> Self {
        // Turning about x (to the right) by a positive angle lifts the view: y points down.
        Self {
            pitch_down_deg: -tilt_x_rad.to_degrees(),
            roll_clockwise_deg: tilt_z_rad.to_degrees(),
            height_m,
        }
    }

    /// Where the camera really is.
    pub fn apply(&self, reported: &Rigid3<Robot, CameraFrame>) -> Rigid3<Robot, CameraFrame> {
        let tilt = Vector3::new(-self.pitch_down_deg.to_radians(), 0.0, self.roll_clockwise_deg.to_radians());
        let turn =
            Rigid3::<CameraFrame, CameraFrame>::new(Rotation3::from_scaled_axis(tilt), Vector3::zeros());
        let up = Rigid3::<Robot, Robot>::new(Rotation3::identity(), Vector3::new(0.0, 0.0, self.height_m));
        up * *reported * turn
    }
}

impl OdometryCorrection {
    /// The real motion of a short reported one, seen from the robot.
    pub fn apply(&self, reported: &PlanarPose) -> PlanarPose {
        let drift_rad = self.drift_deg_per_m.to_radians() * reported.x_m.hypot(reported.y_m);
        PlanarPose::new(
            self.scale[0] * reported.x_m,
            self.scale[1] * reported.y_m,
            self.scale[2] * reported.yaw_rad + drift_rad,
        )
    }
}

/// Corrects odometry that accumulates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OdometryCorrector {
    last: Option<(PlanarPose, PlanarPose)>,
}

impl OdometryCorrector {
    /// The corrected `odom_from_robot` of the next reported one.
    pub fn step(&mut self, reported: &PlanarPose, correction: &OdometryCorrection) -> PlanarPose {
        let corrected = self.last.map_or(*reported, |(last, corrected)| {
            corrected.compose(&correction.apply(&reported.relative_to(&last)))
        });
        self.last = Some((*reported, corrected));
        corrected
    }
}
