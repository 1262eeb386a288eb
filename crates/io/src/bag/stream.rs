//! The messages of a recording, file after file.

use std::{
    collections::VecDeque,
    io::Read,
    path::{Path, PathBuf},
};

use visloc_core::Timestamp;

use crate::bag::{
    BagError, BagTopics, TopicRole,
    container::{BagFile, BagMessage, DamagedBag, MAX_MESSAGE_BYTES, Wanted, unpack},
    decode::RawMessage,
    files::{BagFiles, bag_files},
};

/// All messages of a recording as they stand there: of each file in order of time, or in the order in which an MCAP file
/// has them. Memory does not grow with its length.
pub struct BagMessages {
    files: VecDeque<PathBuf>,
    are_packed: bool,
    wanted: Wanted,
    open: Option<BagFile>,
    num_attachments: usize,
}

visloc_core::debug_shows!([] BagMessages { files, num_attachments });

impl BagMessages {
    /// Opens a recording.
    ///
    /// # Errors
    /// If it is none, or its first file cannot be read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, BagError> {
        let mut messages = Self::new(bag_files(path.as_ref())?, Wanted::All);
        if let Some(first) = messages.files.pop_front() {
            messages.open = Some(BagFile::open(&first, messages.wanted.clone())?);
        }
        Ok(messages)
    }

    pub(super) fn new(files: BagFiles, wanted: Wanted) -> Self {
        Self {
            files: files.paths.into(),
            are_packed: files.are_messages_packed,
            wanted,
            open: None,
            num_attachments: 0,
        }
    }

    /// How many attachments were passed over: files that MCAP holds beside messages.
    pub fn num_attachments(&self) -> usize {
        self.num_attachments
    }

    /// The next message, or what cannot be read. `None` at the end.
    pub fn next_message(&mut self) -> Option<Result<BagMessage, DamagedBag>> {
        loop {
            let Some(open) = &mut self.open else {
                let path = self.files.pop_front()?;
                match BagFile::open(&path, self.wanted.clone()) {
                    Ok(file) => self.open = Some(file),
                    Err(error) => {
                        let reason = format!("cannot open it: {error}");
                        return Some(Err(damage(path, "byte 0", reason, false)));
                    }
                }
                continue;
            };
            match open.next_message() {
                Some(Ok(message)) if self.are_packed => return Some(unpacked(message)),
                Some(next) => return Some(next),
                None => {
                    self.num_attachments += open.num_attachments();
                    self.open = None;
                }
            }
        }
    }
}

/// A message of a recording of rosbag2 with `--compression-mode message`.
fn unpacked(mut message: BagMessage) -> Result<BagMessage, DamagedBag> {
    let mut data = Vec::new();
    let unpack = |data: &mut Vec<u8>| -> std::io::Result<usize> {
        unpack::zstd(&message.data[..])?.take(MAX_MESSAGE_BYTES as u64).read_to_end(data)
    };
    match unpack(&mut data) {
        Ok(_) => {
            message.data = data;
            Ok(message)
        }
        Err(error) => {
            let reason = format!("expected a message packed with zstd: {error}");
            Err(damage(PathBuf::from(&message.channel.topic), "a message", reason, true))
        }
    }
}

fn damage(path: PathBuf, place: &str, reason: String, is_recoverable: bool) -> DamagedBag {
    DamagedBag { path, place: place.into(), reason, is_recoverable }
}

/// Streams the messages of all topics with a role.
pub(super) struct MessageStream {
    topics: BagTopics,
    messages: BagMessages,
}

impl MessageStream {
    pub(super) fn new(files: BagFiles, topics: BagTopics) -> Self {
        let names = TopicRole::ALL.into_iter().map(|role| topics.name(role).to_string());
        let wanted = Wanted::Topics(names.filter(|name| !name.is_empty()).collect());
        Self { topics, messages: BagMessages::new(files, wanted) }
    }

    /// The next message of a topic with a role; `None` at the end.
    pub(super) fn next_message(&mut self) -> Option<Result<RawMessage, DamagedBag>> {
        loop {
            let message = match self.messages.next_message()? {
                Ok(message) => message,
                Err(damage) => return Some(Err(damage)),
            };
            let Some(role) = self.topics.role(&message.channel.topic) else { continue };
            let sent_nanos =
                if message.publish_nanos == 0 { message.log_nanos } else { message.publish_nanos };
            return Some(Ok(RawMessage {
                role,
                is_compressed_image: message.channel.type_name == "sensor_msgs/msg/CompressedImage",
                sent_at: Timestamp::from_nanos(i64::try_from(sent_nanos).unwrap_or(i64::MAX / 4)),
                data: message.data,
            }));
        }
    }
}
