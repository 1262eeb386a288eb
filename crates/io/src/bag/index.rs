//! Which topics a recording has.

use std::{collections::BTreeMap, path::Path};

use crate::bag::{
    BagError, BagTopics, GivenInputs, TopicRole,
    container::{UNREADABLE_ROS1, topics_of_file},
    files::{BagFiles, bag_files},
};

/// A topic of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicInfo {
    /// Name.
    pub topic: String,
    /// Message type, for instance `sensor_msgs/msg/Image`.
    pub type_name: String,
    /// How messages are written; `cdr` for ROS 2.
    pub message_encoding: String,
    /// How many messages there are.
    pub num_messages: u64,
}

impl TopicInfo {
    /// Whether it can be of a role. Many things are texts: a description of a robot is one that is called so.
    pub(crate) fn fits(&self, role: TopicRole) -> bool {
        let is_called = role != TopicRole::RobotDescription || self.topic.ends_with("/robot_description");
        role.type_names().contains(&self.type_name.as_str()) && self.message_encoding == "cdr" && is_called
    }
}

/// The topics of a recording, sorted by name.
pub(crate) fn recorded_topics(path: &str) -> Result<Vec<TopicInfo>, BagError> {
    topics_of_files(&bag_files(Path::new(path))?)
}

/// The topics of all files together, sorted by name.
pub(super) fn topics_of_files(files: &BagFiles) -> Result<Vec<TopicInfo>, BagError> {
    let mut topics: BTreeMap<String, TopicInfo> = BTreeMap::new();
    for file in &files.paths {
        for info in topics_of_file(file)? {
            topics
                .entry(info.topic.clone())
                .and_modify(|known| known.num_messages += info.num_messages)
                .or_insert(info);
        }
    }
    Ok(topics.into_values().collect())
}

/// Checks that what is needed is there, with types that can be read: of the topics that were asked for, those that were chosen.
pub(super) fn check_topics(
    path: &Path,
    available: &[TopicInfo],
    (asked, topics): (&BagTopics, &BagTopics),
    given: &GivenInputs,
) -> Result<(), BagError> {
    let defaults = BagTopics::default();
    let find = |role| available.iter().find(|info| !info.topic.is_empty() && info.topic == topics.name(role));
    let is_named = |role: TopicRole| {
        let name = asked.name(role);
        !name.is_empty() && (name != defaults.name(role) || given.named.contains(&role))
    };
    for role in TopicRole::ALL {
        let is_needed = match role {
            TopicRole::Image => true,
            TopicRole::CameraInfo => given.camera.is_none(),
            TopicRole::Tf if given.robot_from_camera.is_some() => false,
            // The description alone has the place of a camera that is fixed to the robot.
            TopicRole::Tf => {
                let others = [TopicRole::TfStatic, TopicRole::RobotDescription];
                is_named(role)
                    || (given.robot.is_none() && others.into_iter().all(|role| find(role).is_none()))
            }
            _ => is_named(role),
        };
        match find(role) {
            None if !is_needed => {}
            _ => {
                check_topic(path, available, topics, role)?;
            }
        }
    }
    let has_messages = |role| find(role).is_some_and(|info| info.num_messages > 0);
    let has_place = given.robot_from_camera.is_some()
        || given.robot.is_some()
        || [TopicRole::Tf, TopicRole::TfStatic, TopicRole::RobotDescription].into_iter().any(has_messages);
    for role in TopicRole::ALL {
        let is_needed = match role {
            TopicRole::Image => true,
            TopicRole::CameraInfo => given.camera.is_none(),
            TopicRole::Tf => !has_place || is_named(role),
            _ => is_named(role),
        };
        if let Some(info) = find(role).filter(|_| is_needed && !has_messages(role)) {
            return Err(no_messages(path, available, info, role));
        }
    }
    Ok(())
}

/// That a topic which is needed has nothing to say.
pub(super) fn no_messages(
    path: &Path,
    available: &[TopicInfo],
    found: &TopicInfo,
    role: TopicRole,
) -> BagError {
    let is_other =
        |info: &&TopicInfo| info.num_messages > 0 && role.type_names().contains(&info.type_name.as_str());
    BagError::NoMessages {
        path: path.to_path_buf(),
        topic: found.topic.clone(),
        role,
        others: available.iter().filter(is_other).cloned().collect(),
    }
}

/// Checks that the topic of a role is there, with a type that can be read.
pub(super) fn check_topic<'a>(
    path: &Path,
    available: &'a [TopicInfo],
    topics: &BagTopics,
    role: TopicRole,
) -> Result<&'a TopicInfo, BagError> {
    let name = topics.name(role);
    if name.is_empty() {
        return Err(BagError::NotRead { path: path.to_path_buf(), role });
    }
    let expected = || role.type_names().join(" or ");
    let found = available.iter().find(|info| !info.topic.is_empty() && info.topic == name);
    let info = found.ok_or_else(|| BagError::MissingTopic {
        path: path.to_path_buf(),
        topic: name.to_string(),
        role,
        available: available.to_vec(),
    })?;
    if role.type_names().contains(&info.type_name.as_str()) && info.message_encoding == "cdr" {
        return Ok(info);
    }
    if info.message_encoding == UNREADABLE_ROS1 {
        let (topic, type_name) = (info.topic.clone(), info.type_name.clone());
        return Err(BagError::NoDefinition { path: path.to_path_buf(), topic, type_name });
    }
    Err(BagError::WrongType { path: path.to_path_buf(), found: Box::new(info.clone()), expected: expected() })
}

/// What the user can give if a topic of this role is missing.
pub(super) fn instead_of(role: TopicRole) -> &'static str {
    match role {
        TopicRole::CameraInfo => ", or give a calibration with --camera FILE",
        TopicRole::Tf | TopicRole::TfStatic => {
            ", or describe the robot with --urdf FILE, so that the positions of its joints count, or say where the camera is: \
             --camera-height METERS --camera-tilt DEGREES"
        }
        _ => "",
    }
}
