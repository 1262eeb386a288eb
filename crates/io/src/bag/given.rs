//! What the user knows over the messages of a recording, or instead of them.

use std::sync::Arc;

use visloc_core::geom::{Camera, CameraFrame, Rigid3, Robot};

use crate::{
    bag::{BagTopics, TopicRole},
    urdf::RobotDescription,
};

/// Inputs that do not come from messages. The topics that would say the same are not read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GivenInputs {
    /// The camera, for images of its size.
    pub camera: Option<Camera>,
    /// The camera's pose on the robot, which never changes then.
    pub robot_from_camera: Option<Rigid3<Robot, CameraFrame>>,
    /// Which joints the robot has.
    pub robot: Option<Arc<RobotDescription>>,
    /// Whose topics somebody asked for by name, be it the usual one: a recording without messages on them is refused.
    pub named: Vec<TopicRole>,
}

impl GivenInputs {
    /// The topics without those that need not be read.
    pub fn topics_to_read(&self, topics: &BagTopics) -> BagTopics {
        let mut topics = topics.clone();
        if self.camera.is_some() {
            topics.camera_info.clear();
        }
        if self.robot_from_camera.is_some() {
            topics.tf.clear();
            topics.tf_static.clear();
            topics.joint_states.clear();
            topics.imu.clear();
        }
        if self.robot_from_camera.is_some() || self.robot.is_some() {
            topics.robot_description.clear();
        }
        topics
    }
}
