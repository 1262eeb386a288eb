//! The kinds of files that recordings stand in. Each has a module, which gives the topics of a file and its messages.

mod mcap;
mod mcap_records;
mod ros1;
mod ros1_records;
#[cfg(feature = "sqlite")]
mod sqlite;
#[cfg(not(feature = "sqlite"))]
#[path = "no_sqlite.rs"]
mod sqlite;
pub(super) mod unpack;

use std::{
    collections::{BTreeMap, BTreeSet},
    io::{self, Read},
    path::{Path, PathBuf},
    sync::Arc,
};

use visloc_core::files;

pub(in crate::bag) use self::ros1::UNREADABLE_ROS1;
use self::{mcap::McapFile, ros1::Ros1File, sqlite::SqliteFile};
use super::{BagError, TopicInfo};

/// First bytes of a file of SQLite.
const SQLITE_MAGIC: &[u8] = b"SQLite format 3\0";
/// Longest message that is believed, bytes: above any picture, below what a damaged length field asks for.
pub(super) const MAX_MESSAGE_BYTES: usize = 256 << 20;

/// A topic as it stands in a file, with everything that a copy of it needs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Channel {
    /// Name of the topic.
    pub topic: String,
    /// Message type, for instance `sensor_msgs/msg/Image`.
    pub type_name: String,
    /// How messages are written; `cdr` for ROS 2.
    pub message_encoding: String,
    /// How the definition is written, for instance `ros2msg`; empty if there is none.
    pub schema_encoding: String,
    /// Definition of the message type.
    pub schema: Vec<u8>,
    /// Whatever else the file says of the topic, such as its quality of service.
    pub metadata: BTreeMap<String, String>,
}

impl Channel {
    pub(super) fn info(&self, num_messages: u64) -> TopicInfo {
        TopicInfo {
            topic: self.topic.clone(),
            type_name: self.type_name.clone(),
            message_encoding: self.message_encoding.clone(),
            num_messages,
        }
    }
}

/// A message as it stands in a file; those of ROS 1 are turned into those of ROS 2.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BagMessage {
    /// Its topic.
    pub channel: Arc<Channel>,
    /// Its number, where the file has one.
    pub sequence: u32,
    /// When it was recorded, nanoseconds since 1970.
    pub log_nanos: u64,
    /// When it was sent, nanoseconds since 1970; the time of recording where the file does not tell.
    pub publish_nanos: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// Why the messages of a file end early, or a part of them is missing.
#[derive(Debug)]
pub struct DamagedBag {
    /// The file.
    pub path: PathBuf,
    /// Where in the file, for instance `byte 1234`.
    pub place: String,
    /// What was expected and what was found.
    pub reason: String,
    /// Whether reading goes on behind it.
    pub is_recoverable: bool,
}

impl DamagedBag {
    /// File and place.
    pub fn origin(&self) -> String {
        format!("{}: {}", self.path.display(), self.place)
    }
}

/// Which topics are read.
#[derive(Debug, Clone)]
pub(super) enum Wanted {
    All,
    Topics(BTreeSet<String>),
}

impl Wanted {
    fn has(&self, topic: &str) -> bool {
        match self {
            Self::All => true,
            Self::Topics(topics) => topics.contains(topic),
        }
    }
}

/// The kinds of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Mcap,
    Sqlite,
    Ros1,
}

impl Kind {
    /// What a file is by its first bytes; where they tell nothing, by its name.
    fn of(path: &Path) -> io::Result<Self> {
        let mut start = Vec::new();
        files::open(path)?.take(16).read_to_end(&mut start)?;
        if start.starts_with(SQLITE_MAGIC) {
            return Ok(Self::Sqlite);
        }
        if start.starts_with(ros1::MAGIC) {
            return Ok(Self::Ros1);
        }
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        Ok(match extension.as_str() {
            _ if start.starts_with(mcap_records::MAGIC) => Self::Mcap,
            "db3" => Self::Sqlite,
            "bag" => Self::Ros1,
            _ => Self::Mcap,
        })
    }
}

/// The messages of one file. Memory does not grow with its length.
pub(super) struct BagFile(OpenFile);

// One at a time.
#[allow(clippy::large_enum_variant)]
enum OpenFile {
    Mcap(McapFile),
    Sqlite(SqliteFile),
    Ros1(Ros1File),
}

impl BagFile {
    pub(super) fn open(path: &Path, wanted: Wanted) -> Result<Self, BagError> {
        Ok(Self(match kind_of(path)? {
            Kind::Mcap => OpenFile::Mcap(McapFile::open(path, wanted)?),
            Kind::Sqlite => OpenFile::Sqlite(SqliteFile::open(path, wanted)?),
            Kind::Ros1 => OpenFile::Ros1(Ros1File::open(path, wanted)?),
        }))
    }

    /// How many attachments, which are no messages, were passed over so far.
    pub(super) fn num_attachments(&self) -> usize {
        match &self.0 {
            OpenFile::Mcap(file) => file.num_attachments(),
            OpenFile::Sqlite(_) | OpenFile::Ros1(_) => 0,
        }
    }

    /// The next message of a topic that is wanted; `None` at the end.
    pub(super) fn next_message(&mut self) -> Option<Result<BagMessage, DamagedBag>> {
        match &mut self.0 {
            OpenFile::Mcap(file) => file.next_message(),
            OpenFile::Sqlite(file) => file.next_message(),
            OpenFile::Ros1(file) => file.next_message(),
        }
    }
}

/// The topics of one file.
pub(super) fn topics_of_file(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    match kind_of(path)? {
        Kind::Mcap => mcap::topics(path),
        Kind::Sqlite => sqlite::topics(path),
        Kind::Ros1 => ros1::topics(path),
    }
}

fn kind_of(path: &Path) -> Result<Kind, BagError> {
    Kind::of(path).map_err(|source| BagError::Io { path: path.to_path_buf(), action: "open it", source })
}

/// Reads so many bytes into a buffer, in steps: a damaged length must not reserve memory.
fn read_bytes(input: &mut impl Read, num_bytes: usize, buffer: &mut Vec<u8>) -> io::Result<()> {
    buffer.clear();
    let num_read = input.take(num_bytes as u64).read_to_end(buffer)?;
    if num_read < num_bytes { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(()) }
}
