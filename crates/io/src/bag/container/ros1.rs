//! ROS 1 bags. Their messages come out as those of ROS 2.
//!
//! Source: the bag format, version 2.0 (wiki.ros.org/Bags/Format/2.0). The crate that reads it, `rosbag`, maps the file into memory
//! and reserves what a damaged length asks for.

mod layout;

use std::{
    collections::{BTreeMap, VecDeque},
    fs::File,
    io::{self, BufReader, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
    sync::Arc,
};

use self::layout::read_layout;
use super::{
    BagMessage, Channel, DamagedBag, MAX_MESSAGE_BYTES, Wanted,
    ros1_records::{Fields, op, read_header, wrong},
    unpack,
};
use crate::bag::{BagError, TopicInfo, transcode::Transcoder};

/// First bytes of a file, whatever its version.
pub(super) const MAGIC: &[u8] = b"#ROSBAG V";
/// Chunks that overlap in time are unpacked together up to this size, bytes; beyond, messages come a little out of order.
const MAX_OPEN_BYTES: usize = 512 << 20;

/// The messages of a file in order of time.
pub(super) struct Ros1File {
    path: PathBuf,
    file: BufReader<File>,
    wanted: Wanted,
    connections: BTreeMap<u32, Option<Connection>>,
    /// Chunks that are still to come, in order of their first message.
    chunks: VecDeque<ChunkPlace>,
    open: Vec<OpenChunk>,
    damage: VecDeque<DamagedBag>,
    /// What ended the reading of the index.
    end: Option<DamagedBag>,
}

/// Where a chunk stands, and the time of its first message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct ChunkPlace {
    start_nanos: u64,
    at: u64,
}

/// A chunk with its messages in order of time.
struct OpenChunk {
    bytes: Vec<u8>,
    messages: VecDeque<Entry>,
    at: u64,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    nanos: u64,
    connection: u32,
    start: usize,
    end: usize,
}

/// A topic of one publisher.
struct Connection {
    channel: Arc<Channel>,
    /// `None` if its definition cannot be understood: messages come as they are.
    transcoder: Option<Transcoder>,
}

impl Ros1File {
    pub(super) fn open(path: &Path, wanted: Wanted) -> Result<Self, BagError> {
        let (file, layout) = read_layout(path)?;
        let mut chunks = layout.chunks;
        chunks.sort_unstable();
        let mut opened = Self {
            path: path.to_path_buf(),
            file,
            wanted,
            connections: BTreeMap::new(),
            chunks: chunks.into(),
            open: Vec::new(),
            damage: VecDeque::new(),
            end: None,
        };
        opened.end = layout.end.map(|reason| opened.damaged(layout.end_at, reason, false));
        for (id, record) in layout.connections {
            opened.connect(id, &record);
        }
        Ok(opened)
    }

    pub(super) fn next_message(&mut self) -> Option<Result<BagMessage, DamagedBag>> {
        loop {
            if let Some(damage) = self.damage.pop_front() {
                return Some(Err(damage));
            }
            let open_bytes: usize = self.open.iter().map(|chunk| chunk.bytes.len()).sum();
            let first =
                self.open.iter().enumerate().filter_map(|(i, chunk)| {
                    chunk.messages.front().map(|message| (message.nanos, chunk.at, i))
                });
            let first = first.min();
            let is_next = |chunk: &ChunkPlace| match first {
                Some((nanos, ..)) => chunk.start_nanos <= nanos && open_bytes < MAX_OPEN_BYTES,
                None => true,
            };
            if let Some(chunk) = self.chunks.pop_front_if(|chunk| is_next(chunk)) {
                self.open_chunk(chunk.at);
                continue;
            }
            let Some((.., i)) = first else { return self.end.take().map(Err) };
            let chunk = &mut self.open[i];
            let Some(entry) = chunk.messages.pop_front() else { continue };
            let message = message_of(&self.connections, &chunk.bytes, entry);
            let at = chunk.at;
            if chunk.messages.is_empty() {
                self.open.swap_remove(i);
            }
            return Some(message?.map_err(|reason| self.damaged(at, reason, true)));
        }
    }

    /// Unpacks a chunk and lists its messages.
    fn open_chunk(&mut self, at: u64) {
        let unpacked = match read_chunk(&mut self.file, at) {
            Ok(unpacked) => unpacked,
            Err(error) => {
                let damage = self.damaged(at, error.to_string(), true);
                self.damage.push_back(damage);
                return;
            }
        };
        let mut messages = Vec::new();
        let mut connections = Vec::new();
        let parsed = parse_chunk(&unpacked.bytes, |record| match record {
            ChunkRecord::Connection(id, record) => connections.push((id, record)),
            ChunkRecord::Message(entry) => messages.push(entry),
        });
        for (id, record) in connections {
            self.connect(id, &record);
        }
        messages.retain(|entry| matches!(self.connections.get(&entry.connection), Some(Some(_))));
        messages.sort_by_key(|entry| entry.nanos);
        if !messages.is_empty() {
            self.open.push(OpenChunk { bytes: unpacked.bytes, messages: messages.into(), at });
        }
        let fault = unpacked.fault.or(parsed.err());
        // A chunk that is cut off is reported at the end.
        if let Some(reason) = fault.filter(|_| !unpacked.is_cut) {
            let damage = self.damaged(at, reason, true);
            self.damage.push_back(damage);
        }
    }

    fn connect(&mut self, id: u32, record: &ConnectionRecord) {
        let wanted = &self.wanted;
        self.connections.entry(id).or_insert_with(|| wanted.has(&record.topic).then(|| record.connection()));
    }

    fn damaged(&self, at: u64, reason: String, is_recoverable: bool) -> DamagedBag {
        DamagedBag { path: self.path.clone(), place: format!("byte {at}"), reason, is_recoverable }
    }
}

/// A message of ROS 2 from one of a chunk.
fn message_of(
    connections: &BTreeMap<u32, Option<Connection>>,
    chunk: &[u8],
    entry: Entry,
) -> Option<Result<BagMessage, String>> {
    let connection = connections.get(&entry.connection)?.as_ref()?;
    let bytes = &chunk[entry.start..entry.end];
    let data = match &connection.transcoder {
        Some(transcoder) => transcoder.to_cdr(bytes),
        None => Ok(bytes.to_vec()),
    };
    let channel = connection.channel.clone();
    Some(match data {
        Ok(data) => {
            Ok(BagMessage { channel, sequence: 0, log_nanos: entry.nanos, publish_nanos: entry.nanos, data })
        }
        Err(reason) => Err(format!("a message of '{}' ({}): {reason}", channel.topic, channel.type_name)),
    })
}

/// The topics with their counts.
pub(super) fn topics(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    let (_, layout) = read_layout(path)?;
    let count = |id| layout.counts.get(id).copied().unwrap_or(0);
    Ok(layout.connections.iter().map(|(id, record)| record.connection().channel.info(count(id))).collect())
}

/// What a bag says of a connection.
#[derive(Debug)]
struct ConnectionRecord {
    topic: String,
    type_name: String,
    definition: String,
    is_latching: bool,
}

impl ConnectionRecord {
    fn parse(header: &Fields, data: &[u8]) -> Result<(u32, Self), String> {
        let fields = Fields::parse(data)?;
        let topic = header.text("topic").or_else(|| fields.text("topic"));
        let topic = topic.ok_or("expected a connection with a topic")?;
        let type_name = fields.text("type").ok_or("expected a connection with a type")?;
        let definition = fields.text("message_definition").unwrap_or_default();
        let is_latching = fields.get("latching") == Some(b"1");
        Ok((header.u32("conn")?, Self { topic, type_name, definition, is_latching }))
    }

    fn connection(&self) -> Connection {
        let transcoder = Transcoder::new(&self.type_name, &self.definition).ok();
        let (type_name, message_encoding, schema_encoding, schema) = match &transcoder {
            Some(known) => (known.type_name().to_string(), "cdr", "ros2msg", known.definition().into_bytes()),
            None => {
                (self.type_name.clone(), UNREADABLE_ROS1, "ros1msg", self.definition.clone().into_bytes())
            }
        };
        let qos = if self.is_latching { LATCHED } else { "" };
        let channel = Channel {
            topic: self.topic.clone(),
            type_name,
            message_encoding: message_encoding.into(),
            schema_encoding: schema_encoding.into(),
            schema,
            metadata: BTreeMap::from([("offered_qos_profiles".into(), qos.into())]),
        };
        Connection { channel: Arc::new(channel), transcoder }
    }
}

/// The encoding of messages whose definition cannot be understood.
pub(in crate::bag) const UNREADABLE_ROS1: &str = "ros1";

/// The quality of service of ROS 2 that is like a latched topic: whoever comes late gets the last message.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  \
                       lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  liveliness_lease_duration:\n    sec: \
                       9223372036\n    nsec: 854775807\n  avoid_ros_namespace_conventions: false\n";

/// A chunk as far as it could be unpacked.
struct Unpacked {
    bytes: Vec<u8>,
    fault: Option<String>,
    /// Whether the file ends before the chunk does.
    is_cut: bool,
}

/// Reads and unpacks the chunk at a place.
fn read_chunk(file: &mut BufReader<File>, at: u64) -> io::Result<Unpacked> {
    file.seek(SeekFrom::Start(at))?;
    let chunk = read_header(file)?.filter(|(header, _)| header.op() == op::CHUNK);
    let (header, num_bytes) = chunk.ok_or_else(|| wrong("expected a chunk of messages".into()))?;
    let size = header.u32("size").map_err(wrong)? as usize;
    if size > MAX_MESSAGE_BYTES {
        return Err(wrong(format!(
            "expected a chunk of at most {} MiB, found {size} bytes",
            MAX_MESSAGE_BYTES >> 20
        )));
    }
    let is_cut = file.stream_position()? + u64::from(num_bytes) > file.get_ref().metadata()?.len();
    let packed = file.take(u64::from(num_bytes));
    let mut bytes = Vec::new();
    let compression = header.text("compression").unwrap_or_default();
    let read = match compression.as_str() {
        "none" => packed.take(size as u64).read_to_end(&mut bytes),
        "bz2" => unpack::bz2(packed).and_then(|it| it.take(size as u64).read_to_end(&mut bytes)),
        "lz4" => unpack::lz4(packed).and_then(|it| it.take(size as u64).read_to_end(&mut bytes)),
        other => return Err(wrong(format!("expected chunks packed with bz2 or lz4, found '{other}'"))),
    };
    let fault = match read {
        Err(error) => Some(format!("a chunk cannot be unpacked ({compression}): {error}")),
        Ok(_) if bytes.len() < size => {
            Some(format!("expected a chunk of {size} bytes, found {}", bytes.len()))
        }
        Ok(_) => None,
    };
    Ok(Unpacked { bytes, fault, is_cut })
}

/// What stands in a chunk.
enum ChunkRecord {
    Connection(u32, ConnectionRecord),
    Message(Entry),
}

/// Hands over the records of an unpacked chunk.
fn parse_chunk(bytes: &[u8], mut take: impl FnMut(ChunkRecord)) -> Result<(), String> {
    let mut rest = bytes;
    while let Some((header, num_bytes)) = read_header(&mut rest).map_err(|error| error.to_string())? {
        let start = bytes.len() - rest.len();
        let (data, behind) = rest.split_at_checked(num_bytes as usize).ok_or_else(|| {
            format!(
                "expected a record of at most {} bytes, the rest of its chunk, found one of {num_bytes}",
                rest.len()
            )
        })?;
        rest = behind;
        match header.op() {
            op::CONNECTION => {
                let (id, record) = ConnectionRecord::parse(&header, data)?;
                take(ChunkRecord::Connection(id, record));
            }
            op::MESSAGE => take(ChunkRecord::Message(Entry {
                nanos: header.nanos("time")?,
                connection: header.u32("conn")?,
                start,
                end: start + data.len(),
            })),
            _ => {}
        }
    }
    Ok(())
}
