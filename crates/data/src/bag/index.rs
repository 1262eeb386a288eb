//! Which topics a recording has.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{Read, Seek},
    path::{Path, PathBuf},
};

use mcap::{
    Summary,
    records::Record,
    sans_io::{SummaryReadEvent, SummaryReader},
};

use crate::bag::{BagError, BagTopics, TopicRole, records::RecordStream};

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
pub(super) fn topics_of_files(files: &[PathBuf]) -> Result<Vec<TopicInfo>, BagError> {
    let mut topics: BTreeMap<String, TopicInfo> = BTreeMap::new();
    for file in files {
        for info in topics_of_file(file)? {
            topics
                .entry(info.topic.clone())
                .and_modify(|known| known.num_messages += info.num_messages)
                .or_insert(info);
        }
    }
    Ok(topics.into_values().collect())
}

fn topics_of_file(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    let io_error = |source| BagError::Io { path: path.to_path_buf(), action: "read it", source };
    if let Some(topics) = read_summary(path).map_err(io_error)?.as_ref().and_then(topics_of_summary) {
        return Ok(topics);
    }
    scan(path)
}

/// The summary at the end of the file; `None` if there is none or it is damaged.
fn read_summary(path: &Path) -> std::io::Result<Option<Summary>> {
    let mut file = File::open(path)?;
    let mut reader = SummaryReader::new();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(SummaryReadEvent::ReadRequest(num_bytes)) => {
                let num_read = file.read(reader.insert(num_bytes))?;
                reader.notify_read(num_read);
            }
            // Seeking before the start of a file that is too short fails; such a file has no summary.
            Ok(SummaryReadEvent::SeekRequest(to)) => match file.seek(to) {
                Ok(position) => reader.notify_seeked(position),
                Err(_) => return Ok(None),
            },
            Err(_) => return Ok(None),
        }
    }
    Ok(reader.finish())
}

fn topics_of_summary(summary: &Summary) -> Option<Vec<TopicInfo>> {
    let counts = &summary.stats.as_ref()?.channel_message_counts;
    let channels: BTreeMap<_, _> = summary.channels.iter().collect();
    let topics: Vec<_> = channels
        .into_iter()
        .map(|(id, channel)| TopicInfo {
            topic: channel.topic.clone(),
            type_name: channel.schema.as_ref().map_or_else(String::new, |schema| schema.name.clone()),
            message_encoding: channel.message_encoding.clone(),
            num_messages: counts.get(id).copied().unwrap_or(0),
        })
        .collect();
    (!topics.is_empty()).then_some(topics)
}

/// Reads the whole file, for files that were cut off or have no summary. Damage ends it: what comes before counts.
fn scan(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    let mut stream = RecordStream::open(path).map_err(|source| BagError::Io {
        path: path.to_path_buf(),
        action: "open it",
        source,
    })?;
    let mut types: BTreeMap<u16, String> = BTreeMap::new();
    let mut channels: BTreeMap<u16, TopicInfo> = BTreeMap::new();
    let mut first_error = None;
    loop {
        let next = stream.next_with(|record| -> Option<()> {
            match record {
                Record::Schema { header, .. } => {
                    types.insert(header.id, header.name);
                }
                Record::Channel(channel) => {
                    channels.entry(channel.id).or_insert_with(|| TopicInfo {
                        topic: channel.topic,
                        type_name: types.get(&channel.schema_id).cloned().unwrap_or_default(),
                        message_encoding: channel.message_encoding,
                        num_messages: 0,
                    });
                }
                Record::Message { header, .. } => {
                    if let Some(info) = channels.get_mut(&header.channel_id) {
                        info.num_messages += 1;
                    }
                }
                _ => {}
            }
            None
        });
        match next {
            None => break,
            Some(Ok(())) => {}
            Some(Err(error)) => first_error = first_error.or(Some(error)),
        }
    }
    match first_error {
        Some(error) if channels.is_empty() => Err(BagError::NotMcap {
            path: path.to_path_buf(),
            reason: format!("byte {}: {}", error.offset, error.reason),
        }),
        _ => Ok(channels.into_values().collect()),
    }
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
