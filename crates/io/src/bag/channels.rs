//! A recording that is being written: topics and their messages.

use std::{collections::BTreeMap, fs, io::BufWriter, path::PathBuf, sync::Arc};

use mcap::{WriteOptions, Writer, records::MessageHeader};
use serde::Serialize;
use visloc_core::{
    Timestamp,
    files::{GrowingFile, create_alone},
};

use crate::bag::{BagError, BagMessage, Channel, TopicInfo, messages::to_cdr, schemas};

/// A part of the file is completed after so much time of the recording, seconds, or so many bytes. From then on other programs can
/// read it, even if this one is killed.
const PART_SECS: f64 = 0.5;
const PART_BYTES: usize = 1 << 20;

/// Writes messages to an MCAP file and makes a channel for each topic when it is first used. The file is made for the first of them:
/// of a source that gives nothing no recording is left, and an earlier one of that name stays.
pub(super) struct ChannelWriter {
    path: PathBuf,
    options: WriteOptions,
    writer: Option<Writer<BufWriter<GrowingFile>>>,
    channels: Vec<(u16, TopicInfo)>,
    /// Channels of messages that are copied, by where they stand in memory.
    copied: BTreeMap<usize, (u16, Arc<Channel>)>,
    /// Quality of service of channels that have one.
    qos: BTreeMap<u16, String>,
    sequence: u32,
    /// Stamps of the first and the last message.
    span: Option<(Timestamp, Timestamp)>,
    /// When the part at work began, and how long it is.
    part: Option<(Timestamp, usize)>,
    completed_at: Option<Timestamp>,
}

impl ChannelWriter {
    /// For a file; one that is there is replaced when the first message comes.
    pub(super) fn new(path: PathBuf, options: WriteOptions) -> Self {
        // Parts are gathered in memory, so that each comes to the file as a whole.
        let options = options.chunk_size(None).disable_seeking(true);
        Self {
            path,
            options,
            writer: None,
            channels: Vec::new(),
            copied: BTreeMap::new(),
            qos: BTreeMap::new(),
            sequence: 0,
            span: None,
            part: None,
            completed_at: None,
        }
    }

    /// The file, made now if it is not there yet.
    fn writer(&mut self) -> Result<&mut Writer<BufWriter<GrowingFile>>, BagError> {
        if self.writer.is_none() {
            let path = &self.path;
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            let file = folder.map_or(Ok(()), fs::create_dir_all).and_then(|()| create_alone(path));
            let file =
                file.map_err(|source| BagError::Io { path: path.clone(), action: "create it", source })?;
            let writer = self.options.clone().create(BufWriter::new(GrowingFile::new(file)));
            self.writer = Some(writer.map_err(|error| write_error(path, &error))?);
        }
        self.writer.as_mut().ok_or_else(|| BagError::Write {
            path: self.path.clone(),
            reason: "expected a file, found none".into(),
        })
    }

    /// Appends a message. An empty topic is not written.
    pub(super) fn send<T: Serialize>(
        &mut self,
        (topic, type_name): (&str, &str),
        at: Timestamp,
        message: &T,
    ) -> Result<(), BagError> {
        if topic.is_empty() {
            return Ok(());
        }
        let data = to_cdr(message).map_err(|reason| self.encode_error(at, reason))?;
        let channel_id = self.channel(topic, type_name)?;
        self.write(channel_id, at, &data)
    }

    /// Appends bytes in an encoding of their own.
    pub(super) fn send_raw(
        &mut self,
        (topic, encoding): (&str, &str),
        at: Timestamp,
        data: &[u8],
    ) -> Result<(), BagError> {
        let known = self.channels.iter_mut().find(|(_, info)| info.topic == topic);
        let channel_id = match known {
            Some((id, info)) => {
                info.num_messages += 1;
                *id
            }
            None => {
                let added = self.writer()?.add_channel(0, topic, encoding, &BTreeMap::new());
                let id = added.map_err(|error| write_error(&self.path, &error))?;
                self.channels.push((
                    id,
                    TopicInfo {
                        topic: topic.to_string(),
                        type_name: String::new(),
                        message_encoding: encoding.into(),
                        num_messages: 1,
                    },
                ));
                id
            }
        };
        self.write(channel_id, at, data)
    }

    /// Appends a message as it stands in another recording, on a channel like the one there.
    pub(super) fn copy(&mut self, message: &BagMessage) -> Result<(), BagError> {
        let channel = &message.channel;
        let key = Arc::as_ptr(channel) as usize;
        let channel_id = match self.copied.get(&key) {
            Some((id, _)) => *id,
            None => {
                let id = self.add_channel_like(channel)?;
                // Keeps the channel, so that no other one comes to stand at its place.
                self.copied.insert(key, (id, channel.clone()));
                id
            }
        };
        if let Some((_, info)) = self.channels.iter_mut().find(|(id, _)| *id == channel_id) {
            info.num_messages += 1;
        }
        let header = MessageHeader {
            channel_id,
            sequence: message.sequence,
            log_time: message.log_nanos,
            publish_time: message.publish_nanos,
        };
        let at = Timestamp::from_nanos(i64::try_from(message.log_nanos).unwrap_or(i64::MAX));
        self.append(&header, at, &message.data)
    }

    fn add_channel_like(&mut self, channel: &Channel) -> Result<u16, BagError> {
        let has_schema = !channel.type_name.is_empty() || !channel.schema.is_empty();
        let writer = self.writer()?;
        let schema = if has_schema {
            writer.add_schema(&channel.type_name, &channel.schema_encoding, &channel.schema)
        } else {
            Ok(0)
        };
        let id = schema
            .and_then(|schema| {
                writer.add_channel(schema, &channel.topic, &channel.message_encoding, &channel.metadata)
            })
            .map_err(|error| write_error(&self.path, &error))?;
        if self.channels.iter().all(|(known, _)| *known != id) {
            self.channels.push((id, channel.info(0)));
            if let Some(qos) = channel.metadata.get("offered_qos_profiles") {
                self.qos.insert(id, qos.clone());
            }
        }
        Ok(id)
    }

    fn write(&mut self, channel_id: u16, at: Timestamp, data: &[u8]) -> Result<(), BagError> {
        // MCAP counts time from 1970; earlier stamps stay exact in the header of the message.
        let nanos = u64::try_from(at.nanos()).unwrap_or(0);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: nanos, publish_time: nanos };
        self.sequence = self.sequence.wrapping_add(1);
        self.append(&header, at, data)
    }

    fn append(&mut self, header: &MessageHeader, at: Timestamp, data: &[u8]) -> Result<(), BagError> {
        let is_full = |(since, num_bytes): (Timestamp, usize)| is_due(since, at) || num_bytes >= PART_BYTES;
        if self.part.is_some_and(is_full) {
            self.complete_part(at)?;
        }
        let (since, num_bytes) = self.part.unwrap_or((at, 0));
        self.part = Some((since, num_bytes + data.len()));
        let (first, last) = self.span.unwrap_or((at, at));
        self.span = Some((first.min(at), last.max(at)));
        self.writer()?.write_to_known_channel(header, data).map_err(|error| write_error(&self.path, &error))
    }

    /// Completes a part if it is time, for messages that come seldom. To be called when all messages of a moment are written.
    pub(super) fn end_moment(&mut self, at: Timestamp) -> Result<(), BagError> {
        if self.completed_at.is_none_or(|completed_at| is_due(completed_at, at)) {
            self.complete_part(at)?;
        }
        Ok(())
    }

    fn complete_part(&mut self, at: Timestamp) -> Result<(), BagError> {
        (self.part, self.completed_at) = (None, Some(at));
        let flushed = self.writer.as_mut().map_or(Ok(()), Writer::flush);
        flushed.map_err(|error| write_error(&self.path, &error))
    }

    /// Completes the file. Whether there is one.
    pub(super) fn finish(&mut self) -> Result<bool, BagError> {
        let Some(writer) = &mut self.writer else { return Ok(false) };
        match writer.finish() {
            Ok(_) => Ok(true),
            // Why an earlier write failed has been said by that one.
            Err(mcap::McapError::AttemptedWriteAfterFailure) => Ok(false),
            Err(error) => Err(write_error(&self.path, &error)),
        }
    }

    pub(super) fn path(&self) -> &PathBuf {
        &self.path
    }

    /// Topics with their quality of service.
    pub(super) fn topics(&self) -> Vec<(TopicInfo, String)> {
        let with_qos =
            |(id, info): &(u16, TopicInfo)| (info.clone(), self.qos.get(id).cloned().unwrap_or_default());
        self.channels.iter().map(with_qos).collect()
    }

    /// Start and length, nanoseconds.
    pub(super) fn span_nanos(&self) -> (i64, i64) {
        let (first, last) = self.span.unwrap_or_default();
        (first.nanos(), last.nanos() - first.nanos())
    }

    pub(super) fn encode_error(&self, at: Timestamp, reason: String) -> BagError {
        BagError::Encode { path: self.path.clone(), at, reason }
    }

    /// Channel of a topic, made when it is first used; counts the message.
    fn channel(&mut self, topic: &str, type_name: &str) -> Result<u16, BagError> {
        if let Some((id, info)) = self.channels.iter_mut().find(|(_, info)| info.topic == topic) {
            info.num_messages += 1;
            return Ok(*id);
        }
        let definition = schemas::definition(type_name).unwrap_or_default();
        let writer = self.writer()?;
        let id = writer
            .add_schema(type_name, "ros2msg", definition.as_bytes())
            .and_then(|schema| {
                let metadata = [("offered_qos_profiles".to_string(), String::new())].into();
                writer.add_channel(schema, topic, "cdr", &metadata)
            })
            .map_err(|error| write_error(&self.path, &error))?;
        let info = TopicInfo {
            topic: topic.to_string(),
            type_name: type_name.into(),
            message_encoding: "cdr".into(),
            num_messages: 1,
        };
        self.channels.push((id, info));
        Ok(id)
    }
}

fn is_due(since: Timestamp, at: Timestamp) -> bool {
    at.secs_since(since).abs() >= PART_SECS
}

fn write_error(path: &std::path::Path, error: &mcap::McapError) -> BagError {
    // What the system says is more than that it was a system.
    let reason = match error {
        mcap::McapError::Io(source) => source.to_string(),
        error => error.to_string(),
    };
    BagError::Write { path: path.to_path_buf(), reason }
}
