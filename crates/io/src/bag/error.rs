//! Why a recording cannot be opened or written.

use std::{fmt::Write as _, io, path::PathBuf};

use thiserror::Error;

use crate::bag::{TopicInfo, TopicRole, index::instead_of};

/// Why a recording cannot be opened or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BagError {
    /// A file or folder cannot be opened, read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The file is not MCAP, or its beginning is damaged.
    #[error("{}: expected an MCAP file (.mcap): {reason}", path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
        /// What was found.
        reason: String,
    },
    /// The file is not what its first bytes or its name say, or its beginning is damaged.
    #[error("{}: expected {expected}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What it should be.
        expected: &'static str,
        /// What was found.
        reason: String,
    },
    /// A folder has no recording in it, or a part of the recording is missing.
    #[error("{}: {reason}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What was expected and what was found.
        reason: String,
    },
    /// A topic that is needed is not in the recording.
    #[error("{}: topic '{topic}' ({}) is not in the recording; name the right one (on the command line {}){}. {}", path.display(),
             role.type_names().join(" or "), option_of(*role), instead_of(*role), list_of_type(*role, available))]
    MissingTopic {
        /// The recording.
        path: PathBuf,
        /// The topic that is missing.
        topic: String,
        /// What the topic is for.
        role: TopicRole,
        /// The topics that are there.
        available: Vec<TopicInfo>,
    },
    /// The recording has several odometries, none under the default name.
    #[error("{}: several topics have odometry; name one with --odometry-topic, or \"\" to go without. Topics: {}",
            path.display(), list_topics(topics))]
    SeveralOdometries {
        /// The recording.
        path: PathBuf,
        /// The topics that can be meant.
        topics: Vec<TopicInfo>,
    },
    /// A topic that is needed has an empty name, which means that it is not to be read.
    #[error("{}: the topic of {} is set to \"\", so it is not read, and it is needed: name the topic{}",
             path.display(), role.meaning(), instead_of(*role))]
    NotRead {
        /// The recording.
        path: PathBuf,
        /// What the topic is for.
        role: TopicRole,
    },
    /// A topic that is needed is announced in the recording and has no messages.
    #[error("{}: topic '{topic}' for {} has no messages in this recording; name another one (on the command line {}){}{}",
             path.display(), role.meaning(), option_of(*role), instead_of(*role), list_others(others))]
    NoMessages {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// What the topic is for.
        role: TopicRole,
        /// Topics of a fitting type that have messages.
        others: Vec<TopicInfo>,
    },
    /// A topic of ROS 1 whose definition of messages is damaged.
    #[error(
        "{}: topic '{topic}': expected the definition of its messages ({type_name}) among the connections at the end of the bag, found \
         one that cannot be understood; that place is damaged: mend it with rosbag reindex", path.display()
    )]
    NoDefinition {
        /// The bag.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// What the bag says of its messages.
        type_name: String,
    },
    /// A topic has messages of a type that cannot be used.
    #[error("{}: topic '{}' has type '{}' in encoding '{}', expected {expected} in encoding 'cdr'; \
             set another topic name", path.display(), found.topic, found.type_name, found.message_encoding)]
    WrongType {
        /// The recording.
        path: PathBuf,
        /// What is there.
        found: Box<TopicInfo>,
        /// The types that can be used.
        expected: String,
    },
    /// A message cannot be encoded.
    #[error("{}: frame at {at}: {reason}", path.display())]
    Encode {
        /// The recording.
        path: PathBuf,
        /// Stamp of the frame.
        at: visloc_core::Timestamp,
        /// What went wrong.
        reason: String,
    },
    /// The MCAP library refused to write.
    #[error("{}: cannot write the recording: {reason}", path.display())]
    Write {
        /// The recording.
        path: PathBuf,
        /// What the library says.
        reason: String,
    },
}

/// Those of the wanted types first.
fn list_of_type(role: TopicRole, topics: &[TopicInfo]) -> String {
    let (fitting, others): (Vec<TopicInfo>, Vec<TopicInfo>) =
        topics.iter().cloned().partition(|topic| role.type_names().contains(&topic.type_name.as_str()));
    let none = if fitting.is_empty() && !topics.is_empty() { ", none of them of that type" } else { "" };
    format!("Topics there{none}: {}", list_topics(&[fitting, others].concat()))
}

/// The options that name the topic of a role.
fn option_of(role: TopicRole) -> &'static str {
    match role {
        TopicRole::Image => "--image-topic or --topics",
        TopicRole::CameraInfo => "--camera-info-topic or --topics",
        TopicRole::Odometry => "--odometry-topic or --topics",
        TopicRole::GroundTruth => "--truth-topic or --topics",
        _ => "--topics",
    }
}

/// What could be named instead, as the end of a sentence.
fn list_others(topics: &[TopicInfo]) -> String {
    if topics.is_empty() {
        String::new()
    } else {
        format!("; of the same type and with messages: {}", list_topics(topics))
    }
}

fn list_topics(topics: &[TopicInfo]) -> String {
    if topics.is_empty() {
        return "none".into();
    }
    let mut list = String::new();
    for (i, topic) in topics.iter().enumerate() {
        let separator = if i == 0 { "" } else { ", " };
        // Writing to a string cannot fail.
        let _ = write!(list, "{separator}{} ({})", topic.topic, topic.type_name);
    }
    list
}
