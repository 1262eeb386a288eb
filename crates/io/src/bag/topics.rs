//! Names of topics and frames in a recording.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

visloc_core::worded_enum! {
    /// What a topic is for.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum TopicRole {
        /// The camera's pictures.
        Image = "the images",
        /// The camera's calibration.
        CameraInfo = "the calibration",
        /// Accumulated odometry.
        Odometry = "the odometry",
        /// Poses between frames that move, kinematics.
        Tf = "the kinematics (tf)",
        /// Poses between frames that do not move.
        TfStatic = "the fixed transforms (tf_static)",
        /// Positions of the robot's joints.
        JointStates = "the positions of joints",
        /// Which joints are where on the robot.
        RobotDescription = "the robot's description",
        /// How the robot is tilted.
        Imu = "the tilt (IMU)",
        /// Whether the feet touch the ground.
        FootContact = "the contact of the feet",
        /// Forces under the feet.
        FootPressure = "the forces under the feet",
        /// Where the robot really is.
        GroundTruth = "the truth",
    }

    /// What is on a topic of this role, for people.
    meaning
}

impl TopicRole {
    /// Message types that a topic of this role may have.
    pub fn type_names(self) -> &'static [&'static str] {
        match self {
            Self::Image => &["sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image"],
            Self::CameraInfo => &["sensor_msgs/msg/CameraInfo"],
            Self::Odometry => &["nav_msgs/msg/Odometry"],
            // The second is that of ROS 1 before tf2.
            Self::Tf | Self::TfStatic => &["tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"],
            Self::JointStates => &["sensor_msgs/msg/JointState"],
            Self::RobotDescription => &["std_msgs/msg/String"],
            Self::Imu => &["sensor_msgs/msg/Imu"],
            Self::FootContact => &["std_msgs/msg/Bool"],
            Self::FootPressure => &["std_msgs/msg/Float64MultiArray"],
            Self::GroundTruth => &["geometry_msgs/msg/PoseStamped"],
        }
    }
}

visloc_core::with_defaults! {
    /// Names of the topics and frames of a recording. An empty topic name means: do not read this topic. The recording
    /// must have the image topic, the calibration topic (or the camera is given), one of the two `tf` topics or the robot's description
    /// (or that or the camera's place is given), and every topic whose name is not the default.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
    #[serde(default, deny_unknown_fields)]
    pub struct BagTopics {
        /// Pictures: `sensor_msgs/msg/CompressedImage` (JPEG, PNG) or `sensor_msgs/msg/Image` (rgb8, Bayer,
        /// YUV and others).
        pub image: String = "/camera/image/compressed".into(),
        /// Pictures of the robot's further cameras. The calibration of each is read from beside its pictures (`/eye/camera_info` for
        /// `/eye/image_raw/compressed`), and its frame is the one that the pictures name.
        pub more_images: Vec<String> = Vec::new(),
        /// Calibration, `sensor_msgs/msg/CameraInfo`.
        pub camera_info: String = "/camera/camera_info".into(),
        /// Odometry, `nav_msgs/msg/Odometry`.
        pub odometry: String = "/odom".into(),
        /// Kinematics, `tf2_msgs/msg/TFMessage`.
        pub tf: String = "/tf".into(),
        /// Poses that do not change, `tf2_msgs/msg/TFMessage`.
        pub tf_static: String = "/tf_static".into(),
        /// Positions of the robot's joints, `sensor_msgs/msg/JointState`. With the description they say where frames are of which `tf` and
        /// `tf_static` say nothing.
        pub joint_states: String = "/joint_states".into(),
        /// Description of the robot (URDF), `std_msgs/msg/String`.
        pub robot_description: String = "/robot_description".into(),
        /// How the robot is tilted, `sensor_msgs/msg/Imu` with an orientation. By default none is read: transforms that begin on the ground say it
        /// as well. Where they take a trunk for level that is not, name the topic.
        pub imu: String = String::new(),
        /// Whether the feet touch the ground, `std_msgs/msg/Bool`.
        pub foot_contact: String = "/foot_contact".into(),
        /// Eight forces in newtons, left foot first, `std_msgs/msg/Float64MultiArray`. Wins over `foot_contact`.
        pub foot_pressure: String = "/foot_pressure".into(),
        /// Where the robot really is, `geometry_msgs/msg/PoseStamped` in the map frame.
        pub ground_truth: String = "/ground_truth/pose".into(),
        /// Frame of the robot on the ground: x forward, y left, z up.
        pub base_frame: String = "base_footprint".into(),
        /// Optical frame of the camera. By default the one that the pictures name in their header.
        pub camera_frame: Option<String> = None,
    }
}

impl BagTopics {
    /// No topic at all, the usual frames.
    pub(super) fn none() -> Self {
        Self {
            image: String::new(),
            camera_info: String::new(),
            odometry: String::new(),
            tf: String::new(),
            tf_static: String::new(),
            joint_states: String::new(),
            robot_description: String::new(),
            imu: String::new(),
            foot_contact: String::new(),
            foot_pressure: String::new(),
            ground_truth: String::new(),
            ..Self::default()
        }
    }

    /// Name of the topic with a role; empty if it is not to be read.
    pub fn name(&self, role: TopicRole) -> &str {
        match role {
            TopicRole::Image => &self.image,
            TopicRole::CameraInfo => &self.camera_info,
            TopicRole::Odometry => &self.odometry,
            TopicRole::Tf => &self.tf,
            TopicRole::TfStatic => &self.tf_static,
            TopicRole::JointStates => &self.joint_states,
            TopicRole::RobotDescription => &self.robot_description,
            TopicRole::Imu => &self.imu,
            TopicRole::FootContact => &self.foot_contact,
            TopicRole::FootPressure => &self.foot_pressure,
            TopicRole::GroundTruth => &self.ground_truth,
        }
    }

    /// Topics of pictures and calibration of a camera, and its optical frame, for whoever writes them: those of a further camera without a
    /// name are numbered.
    pub(super) fn of_camera(&self, camera_index: usize) -> (String, String, String) {
        let numbered = format!("camera_{}", camera_index + 1);
        let Some(further) = camera_index.checked_sub(1) else {
            let frame = self.camera_frame.clone().unwrap_or_else(|| "camera_optical".into());
            return (self.image.clone(), self.camera_info.clone(), frame);
        };
        let named = self.more_images.get(further).cloned();
        let image = named.unwrap_or_else(|| format!("/{numbered}/image/compressed"));
        let camera_info = camera_info_beside(&image);
        (image, camera_info, format!("{numbered}_optical"))
    }

    /// Role of a topic, if it has one.
    pub fn role(&self, topic: &str) -> Option<TopicRole> {
        TopicRole::ALL.into_iter().find(|role| !topic.is_empty() && self.name(*role) == topic)
    }
}

/// Where a calibration stands beside pictures as a rule.
pub(super) fn camera_info_beside(image: &str) -> String {
    let image = image.strip_suffix("/compressed").unwrap_or(image);
    format!("{}/camera_info", image.rsplit_once('/').map_or("", |(above, _)| above))
}

/// How images are asked for on live topics.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ImageQos {
    /// What is lost on the way is lost; publishers of both kinds are heard.
    #[default]
    BestEffort,
    /// What is lost is sent again; publishers that are best effort are not heard.
    Reliable,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_override_single_names() {
        let topics: BagTopics = toml::from_str("image = \"/eye\"\nodometry = \"\"").unwrap();
        assert_eq!(topics.role("/eye"), Some(TopicRole::Image));
        assert_eq!(topics.role("/tf"), Some(TopicRole::Tf));
        assert_eq!(topics.role(""), None);
        let topics: BagTopics = toml::from_str("more_images = [\"/low/image_raw/compressed\"]").unwrap();
        assert_eq!(topics.of_camera(0).1, "/camera/camera_info");
        assert_eq!(topics.of_camera(1).1, "/low/camera_info");
        assert_eq!(topics.of_camera(2).0, "/camera_3/image/compressed");
        assert!(toml::from_str::<BagTopics>("imgae = \"/eye\"").is_err());
    }
}
