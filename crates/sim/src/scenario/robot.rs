//! The table `[robot]`: body, head, gait and sensors besides the camera.

use serde::Deserialize;
use visloc_core::geom::nao::NaoCamera;

use super::{check::Check, load::ScenarioError};

/// How the camera sits on the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeadMount {
    /// On a neck of the given height and offset, along the axis of the head.
    Simple,
    /// Forehead of the Nao V3.
    NaoTopV3,
    /// Mouth of the Nao V3.
    NaoBottomV3,
    /// Forehead of the Nao V4 and later.
    NaoTopV4,
    /// Mouth of the Nao V4 and later.
    NaoBottomV4,
}

impl HeadMount {
    /// The Nao's camera, if it is one.
    pub fn nao_camera(self) -> Option<NaoCamera> {
        match self {
            Self::Simple => None,
            Self::NaoTopV3 => Some(NaoCamera::TopV3),
            Self::NaoBottomV3 => Some(NaoCamera::BottomV3),
            Self::NaoTopV4 => Some(NaoCamera::TopV4),
            Self::NaoBottomV4 => Some(NaoCamera::BottomV4),
        }
    }
}

visloc_core::with_defaults! {
    /// Everything about the robot.
    /// By default a small humanoid whose camera is 47 cm above the floor.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct RobotSetup {
        /// Where the camera is.
        pub mount: HeadMount = HeadMount::Simple,
        /// Height of the neck joint while walking, meters.
        pub neck_height_m: f64 = 0.41,
        /// From the neck joint to the camera, forward, meters; simple mount only.
        pub eye_forward_m: f64 = 0.045,
        /// From the neck joint to the camera, up, meters; simple mount only.
        pub eye_up_m: f64 = 0.06,
        /// The head's motion.
        pub head: HeadSetup = HeadSetup::default(),
        /// The sway of walking.
        pub gait: GaitSetup = GaitSetup::default(),
        /// Errors of the odometry.
        pub odometry: OdometrySetup = OdometrySetup::default(),
        /// Errors of the reported camera pose.
        pub kinematics: KinematicsSetup = KinematicsSetup::default(),
        /// The pressure sensors.
        pub feet: FootSetup = FootSetup::default(),
    }
}

visloc_core::with_defaults! {
    /// The head pans from side to side, resting a little at the ends, and nods slowly.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct HeadSetup {
        /// Mean pan, positive to the left, degrees.
        pub pan_mean_deg: f64 = 0.0,
        /// Largest pan to either side, degrees.
        pub pan_deg: f64 = 55.0,
        /// Time for going there and back.
        pub pan_period_secs: f64 = 6.5,
        /// Mean tilt, positive down, degrees.
        pub tilt_deg: f64 = 13.0,
        /// How far the tilt swings around its mean, degrees.
        pub tilt_swing_deg: f64 = 6.0,
        /// Time of one swing of the tilt.
        pub tilt_period_secs: f64 = 11.0,
    }
}

visloc_core::with_defaults! {
    /// How much the body sways while it walks.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct GaitSetup {
        /// Steps per second, both feet counted.
        pub steps_per_sec: f64 = 1.9,
        /// Largest roll, degrees.
        pub roll_deg: f64 = 1.8,
        /// Largest pitch, degrees.
        pub pitch_deg: f64 = 1.1,
        /// Sideways, meters.
        pub sway_m: f64 = 0.014,
        /// Up and down, meters.
        pub bounce_m: f64 = 0.006,
    }
}

visloc_core::with_defaults! {
    /// Errors of the odometry. Each run draws its own scale errors between the limits, with random signs.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct OdometrySetup {
        /// Smallest and largest error of scale, the same limits for forward, sideways and turn; 0.05 is 5 %.
        pub scale_error: [f64; 2] = [0.05, 0.10],
        /// Standard deviation of the turn that creeps in per meter, degrees.
        pub turn_bias_deg_per_m: f64 = 1.0,
        /// Standard deviation of the position after one meter, meters; grows with the root of the way.
        pub noise_m: f64 = 0.01,
        /// Standard deviation of the heading after one meter, degrees; grows with the root of the way.
        pub noise_deg: f64 = 1.15,
    }
}

visloc_core::with_defaults! {
    /// Errors of the pose of the camera that the joints report.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct KinematicsSetup {
        /// White noise of the position, standard deviation, meters.
        pub noise_m: f64 = 0.002,
        /// White noise of each angle, standard deviation, degrees.
        pub noise_deg: f64 = 0.2,
        /// Largest error that comes and goes slowly, each angle, degrees.
        pub bias_deg: f64 = 0.5,
        /// Largest error of the height that comes and goes slowly, meters.
        pub height_bias_m: f64 = 0.003,
        /// How far the camera is turned about the robot's axes against where it is reported (roll, pitch, yaw), constant, degrees.
        pub mount_deg: [f64; 3] = [0.0; 3],
    }
}

visloc_core::with_defaults! {
    /// The eight pressure sensors under the feet.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct FootSetup {
        /// Weight of the robot, newtons.
        pub weight_n: f64 = 45.0,
        /// Standard deviation of each sensor, newtons.
        pub noise_n: f64 = 0.25,
    }
}

impl RobotSetup {
    pub(super) fn check(&self, check: &Check<'_>) -> Result<(), ScenarioError> {
        let range = |key: &str, value: f64, low: f64, high: f64| {
            check.range(&format!("robot.{key}"), value, low..=high)
        };
        range("neck_height_m", self.neck_height_m, 0.05, 5.0)?;
        range("eye_forward_m", self.eye_forward_m, -1.0, 1.0)?;
        range("eye_up_m", self.eye_up_m, -1.0, 1.0)?;
        range("head.pan_mean_deg", self.head.pan_mean_deg, -180.0, 180.0)?;
        range("head.pan_deg", self.head.pan_deg, 0.0, 180.0)?;
        range("head.pan_period_secs", self.head.pan_period_secs, 0.5, 600.0)?;
        range("head.tilt_deg", self.head.tilt_deg, -90.0, 90.0)?;
        range("head.tilt_swing_deg", self.head.tilt_swing_deg, 0.0, 90.0)?;
        range("head.tilt_period_secs", self.head.tilt_period_secs, 0.5, 600.0)?;
        range("gait.steps_per_sec", self.gait.steps_per_sec, 0.1, 10.0)?;
        range("gait.roll_deg", self.gait.roll_deg, 0.0, 30.0)?;
        range("gait.pitch_deg", self.gait.pitch_deg, 0.0, 30.0)?;
        range("gait.sway_m", self.gait.sway_m, 0.0, 0.2)?;
        range("gait.bounce_m", self.gait.bounce_m, 0.0, 0.2)?;
        let [least, most] = self.odometry.scale_error;
        range("odometry.scale_error", least, 0.0, 0.9)?;
        range("odometry.scale_error", most, least, 0.9)?;
        range("odometry.turn_bias_deg_per_m", self.odometry.turn_bias_deg_per_m, 0.0, 90.0)?;
        range("odometry.noise_m", self.odometry.noise_m, 0.0, 1.0)?;
        range("odometry.noise_deg", self.odometry.noise_deg, 0.0, 90.0)?;
        range("kinematics.noise_m", self.kinematics.noise_m, 0.0, 1.0)?;
        range("kinematics.noise_deg", self.kinematics.noise_deg, 0.0, 45.0)?;
        range("kinematics.bias_deg", self.kinematics.bias_deg, 0.0, 45.0)?;
        range("kinematics.height_bias_m", self.kinematics.height_bias_m, 0.0, 1.0)?;
        for angle in self.kinematics.mount_deg {
            range("kinematics.mount_deg", angle, -45.0, 45.0)?;
        }
        range("feet.weight_n", self.feet.weight_n, 0.1, 10_000.0)?;
        range("feet.noise_n", self.feet.noise_n, 0.0, 1000.0)
    }
}
