//! Moves a robot by topics.

use ros2_client::Publisher;
use visloc_core::geom::nao::HeadAngles;

use crate::{
    bag::messages::{Header, JointTrajectory, JointTrajectoryPoint, Time, Twist, Vector3},
    ros2::{
        Node, NodeSettings, Ros2Error,
        node::{Delivery, Watch},
    },
};

/// Time for the head to get to where it is to look, nanoseconds.
const HEAD_NANOS: u32 = 300_000_000;

/// What a robot listens to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DriveTopics {
    /// Speeds, `geometry_msgs/Twist`.
    pub velocity: String,
    /// Joints of the head, `trajectory_msgs/JointTrajectory`, as the controllers of `ros2_control` take it.
    pub head: String,
    /// Names of the joints: to the left, and down.
    pub joints: [String; 2],
}

impl Default for DriveTopics {
    /// `/cmd_vel`, `/head_controller/joint_trajectory`, `head_pan_joint` and `head_tilt_joint`.
    fn default() -> Self {
        Self {
            velocity: "/cmd_vel".into(),
            head: "/head_controller/joint_trajectory".into(),
            joints: ["head_pan_joint".into(), "head_tilt_joint".into()],
        }
    }
}

/// Tells a robot how to move.
pub struct DrivePublisher {
    velocity: Publisher<Twist>,
    head: Publisher<JointTrajectory>,
    joints: [String; 2],
    settings: (NodeSettings, DriveTopics),
    watch: Watch,
    /// Leaves the network last.
    node: Node,
}

visloc_core::debug_shows!([] DrivePublisher { joints, settings });

impl DrivePublisher {
    /// Advertises the topics. Nothing is said before the first order.
    ///
    /// # Errors
    /// If there is no network, or a name is none.
    pub fn open(settings: &NodeSettings, topics: &DriveTopics) -> Result<Self, Ros2Error> {
        let mut node = Node::join(settings)?;
        Ok(Self {
            velocity: node.advertise(&topics.velocity, "geometry_msgs/msg/Twist", Delivery::Last)?,
            head: node.advertise(&topics.head, "trajectory_msgs/msg/JointTrajectory", Delivery::Last)?,
            joints: topics.joints.clone(),
            settings: (settings.clone(), topics.clone()),
            watch: Watch::default(),
            node,
        })
    }

    /// Advertises the topics anew if the network was left. To be called again and again.
    pub fn keep_joined(&mut self) {
        if self.watch.sees_that_left(&self.node)
            && let Ok(anew) = Self::open(&self.settings.0, &self.settings.1)
        {
            *self = anew;
        }
    }

    /// Speeds ahead and to the left, meters per second, and counter-clockwise, radians per second. Whether it was sent.
    pub fn drive(&self, [forward, left, turn]: [f64; 3]) -> bool {
        let linear = Vector3 { x: forward, y: left, z: 0.0 };
        let angular = Vector3 { x: 0.0, y: 0.0, z: turn };
        self.velocity.publish(Twist { linear, angular }).is_ok()
    }

    /// Turns the head. Whether it was sent.
    pub fn look(&self, angles: HeadAngles) -> bool {
        let point = JointTrajectoryPoint {
            positions: vec![angles.yaw_rad, angles.pitch_rad],
            time_from_start: Time { sec: 0, nanosec: HEAD_NANOS },
            ..JointTrajectoryPoint::default()
        };
        let trajectory = JointTrajectory {
            // A stamp of 0: at once, whatever the robot's clock says.
            header: Header::default(),
            joint_names: self.joints.to_vec(),
            points: vec![point],
        };
        self.head.publish(trajectory).is_ok()
    }
}
