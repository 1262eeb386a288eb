//! The messages of a recording, file after file.

use std::{
    collections::{BTreeMap, VecDeque},
    path::PathBuf,
};

use mcap::records::Record;
use visloc_base::Timestamp;

use crate::bag::{
    BagTopics, TopicRole,
    decode::RawMessage,
    records::{RecordError, RecordStream},
};

/// Streams the messages of all topics with a role.
pub(super) struct MessageStream {
    topics: BagTopics,
    files: VecDeque<PathBuf>,
    stream: Option<RecordStream>,
    channels: Channels,
}

/// What the channels of the file at hand are for.
#[derive(Default)]
struct Channels {
    types: BTreeMap<u16, String>,
    roles: BTreeMap<u16, (TopicRole, bool)>,
}

impl MessageStream {
    pub(super) fn new(files: Vec<PathBuf>, topics: BagTopics) -> Self {
        Self { topics, files: files.into(), stream: None, channels: Channels::default() }
    }

    /// The next message of a topic with a role; `None` at the end.
    pub(super) fn next_message(&mut self) -> Option<Result<RawMessage, RecordError>> {
        loop {
            if self.stream.is_none() {
                let file = self.files.pop_front()?;
                self.channels = Channels::default();
                match RecordStream::open(&file) {
                    Ok(stream) => self.stream = Some(stream),
                    Err(error) => {
                        let reason = format!("cannot open it: {error}");
                        return Some(Err(RecordError {
                            path: file,
                            offset: 0,
                            reason,
                            is_recoverable: false,
                        }));
                    }
                }
            }
            let (channels, topics) = (&mut self.channels, &self.topics);
            match self.stream.as_mut()?.next_with(|record| channels.take(record, topics)) {
                Some(next) => return Some(next),
                None => self.stream = None,
            }
        }
    }
}

impl Channels {
    /// Learns the channels of the file and picks the messages of those with a role.
    fn take(&mut self, record: Record<'_>, topics: &BagTopics) -> Option<RawMessage> {
        match record {
            Record::Schema { header, .. } => {
                self.types.insert(header.id, header.name);
                None
            }
            Record::Channel(channel) => {
                if let Some(role) = topics.role(&channel.topic) {
                    let type_name = self.types.get(&channel.schema_id).map(String::as_str);
                    let is_compressed = type_name == Some("sensor_msgs/msg/CompressedImage");
                    self.roles.insert(channel.id, (role, is_compressed));
                }
                None
            }
            Record::Message { header, data } => {
                let (role, is_compressed_image) = *self.roles.get(&header.channel_id)?;
                let sent_nanos = if header.publish_time == 0 { header.log_time } else { header.publish_time };
                let sent_at = Timestamp::from_nanos(i64::try_from(sent_nanos).unwrap_or(i64::MAX / 4));
                Some(RawMessage { role, is_compressed_image, sent_at, data: data.into_owned() })
            }
            _ => None,
        }
    }
}
