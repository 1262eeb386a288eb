//! Which topics a recording has.

use std::{collections::BTreeMap, path::Path};

use crate::bag::{BagError, BagTopics, TopicRole, container::topics_of_file, files::BagFiles};

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

/// Checks that what is needed is there, with types that can be read.
pub(super) fn check_topics(path: &Path, available: &[TopicInfo], topics: &BagTopics) -> Result<(), BagError> {
    let defaults = BagTopics::default();
    let find = |role| available.iter().find(|info| !info.topic.is_empty() && info.topic == topics.name(role));
    for role in TopicRole::ALL {
        let name = topics.name(role);
        let is_renamed = !name.is_empty() && name != defaults.name(role);
        let is_needed = match role {
            TopicRole::Image | TopicRole::CameraInfo => true,
            TopicRole::Tf => is_renamed || find(TopicRole::TfStatic).is_none(),
            _ => is_renamed,
        };
        match find(role) {
            None if !is_needed => {}
            _ => {
                check_topic(path, available, topics, role)?;
            }
        }
    }
    Ok(())
}

/// Checks that the topic of a role is there, with a type that can be read.
pub(super) fn check_topic<'a>(
    path: &Path,
    available: &'a [TopicInfo],
    topics: &BagTopics,
    role: TopicRole,
) -> Result<&'a TopicInfo, BagError> {
    let name = topics.name(role);
    let expected = || role.type_names().join(" or ");
    let found = available.iter().find(|info| !info.topic.is_empty() && info.topic == name);
    let info = found.ok_or_else(|| BagError::MissingTopic {
        path: path.to_path_buf(),
        topic: name.to_string(),
        expected_type: expected(),
        available: available.to_vec(),
    })?;
    if role.type_names().contains(&info.type_name.as_str()) && info.message_encoding == "cdr" {
        return Ok(info);
    }
    Err(BagError::WrongType { path: path.to_path_buf(), found: Box::new(info.clone()), expected: expected() })
}
