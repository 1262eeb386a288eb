//! SQLite, the default of rosbag2 until Humble.
//!
//! Source: the schema of `rosbag2_storage_sqlite3`, versions 1 to 4: tables `topics` and `messages`, and since Iron
//! `message_definitions`.

use std::{
    collections::{BTreeMap, VecDeque},
    fmt::Write as _,
    io::Read as _,
    path::{Path, PathBuf},
    sync::Arc,
};

use rusqlite::{Connection, OpenFlags, OptionalExtension, Row, limits::Limit};
use visloc_core::files;

use super::{BagMessage, Channel, DamagedBag, MAX_MESSAGE_BYTES, Wanted};
use crate::bag::{BagError, TopicInfo, schemas};

/// How many places of messages are looked up at once.
const NUM_KEYS: i64 = 4096;

/// The messages of a file in the order in which they were recorded.
pub(super) struct SqliteFile {
    path: PathBuf,
    database: Connection,
    channels: BTreeMap<i64, Arc<Channel>>,
    /// Time, number and topic of the next messages.
    keys: VecDeque<Key>,
    /// The last of the keys that were looked up.
    last: Option<(i64, i64)>,
    order: Order,
    /// What is wrong with the size of the file, until it is told.
    size_fault: Option<String>,
    is_done: bool,
}

#[derive(Debug, Clone, Copy)]
struct Key {
    nanos: i64,
    id: i64,
    topic: i64,
}

/// How messages are gone through without sorting them all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Order {
    /// By time, with the help of the index that rosbag2 makes.
    Time,
    /// As written, where there is no such index.
    Number,
}

impl Order {
    fn query(self) -> &'static str {
        match self {
            Self::Time => {
                "SELECT timestamp, id, topic_id FROM messages WHERE timestamp >= ?1 AND (timestamp > ?1 OR id > ?2) \
                 ORDER BY timestamp, id LIMIT ?3"
            }
            Self::Number => {
                "SELECT timestamp, id, topic_id FROM messages WHERE id > ?2 AND ?1 IS NOT NULL ORDER BY id LIMIT ?3"
            }
        }
    }
}

impl SqliteFile {
    pub(super) fn open(path: &Path, wanted: Wanted) -> Result<Self, BagError> {
        let database = open(path)?;
        let mut channels = channels(&database).map_err(|error| damaged(path, &error))?;
        channels.retain(|_, channel| wanted.has(&channel.topic));
        let has_index = "SELECT 1 FROM pragma_index_list('messages') AS list, pragma_index_info(list.name) AS info \
                         WHERE info.seqno = 0 AND info.name = 'timestamp' AND list.partial = 0";
        let has_index = database.query_row(has_index, [], |_| Ok(())).optional();
        let has_index = has_index.map_err(|error| damaged(path, &error))?.is_some();
        Ok(Self {
            path: path.to_path_buf(),
            database,
            channels: channels.into_iter().map(|(id, channel)| (id, Arc::new(channel))).collect(),
            keys: VecDeque::new(),
            last: None,
            size_fault: size_fault(path),
            order: if has_index { Order::Time } else { Order::Number },
            is_done: false,
        })
    }

    pub(super) fn next_message(&mut self) -> Option<Result<BagMessage, DamagedBag>> {
        if let Some(reason) = self.size_fault.take() {
            let (path, place) = (self.path.clone(), "its size".into());
            return Some(Err(DamagedBag { path, place, reason, is_recoverable: true }));
        }
        while !self.is_done {
            let Some(key) = self.keys.pop_front() else {
                if let Err(error) = self.look_ahead() {
                    self.is_done = true;
                    return Some(Err(self.damage("its table of messages", &error, false)));
                }
                self.is_done = self.keys.is_empty();
                continue;
            };
            let Some(channel) = self.channels.get(&key.topic).cloned() else { continue };
            let nanos = u64::try_from(key.nanos).unwrap_or(0);
            return Some(match self.data(key.id) {
                Ok(data) => {
                    let sequence = u32::try_from(key.id).unwrap_or(0);
                    Ok(BagMessage { channel, sequence, log_nanos: nanos, publish_nanos: nanos, data })
                }
                Err(error) => Err(self.damage(&format!("message {}", key.id), &error, true)),
            });
        }
        None
    }

    fn look_ahead(&mut self) -> rusqlite::Result<()> {
        let (nanos, id) = self.last.unwrap_or((i64::MIN, i64::MIN));
        let mut statement = self.database.prepare_cached(self.order.query())?;
        let read = |row: &Row<'_>| Ok(Key { nanos: row.get(0)?, id: row.get(1)?, topic: row.get(2)? });
        for key in statement.query_map((nanos, id, NUM_KEYS), read)? {
            let key = key?;
            // A damaged index must not lead round in circles.
            let is_behind = match self.order {
                Order::Time => self.last.is_none_or(|last| (key.nanos, key.id) > last),
                Order::Number => self.last.is_none_or(|last| key.id > last.1),
            };
            if is_behind {
                self.last = Some((key.nanos, key.id));
                self.keys.push_back(key);
            }
        }
        Ok(())
    }

    fn data(&self, id: i64) -> rusqlite::Result<Vec<u8>> {
        let mut statement = self.database.prepare_cached("SELECT data FROM messages WHERE id = ?1")?;
        statement.query_row([id], |row| row.get(0))
    }

    fn damage(&self, place: &str, error: &rusqlite::Error, is_recoverable: bool) -> DamagedBag {
        let reason = format!("cannot read on: {error}");
        DamagedBag { path: self.path.clone(), place: place.into(), reason, is_recoverable }
    }
}

/// The topics with their counts.
pub(super) fn topics(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    let database = open(path)?;
    let count = || -> rusqlite::Result<Vec<TopicInfo>> {
        let channels = channels(&database)?;
        let mut counts: BTreeMap<i64, u64> = BTreeMap::new();
        let mut statement = database.prepare("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id")?;
        for row in statement.query_map([], |row| Ok((row.get(0)?, row.get::<_, i64>(1)?)))? {
            let (topic, number) = row?;
            counts.insert(topic, u64::try_from(number).unwrap_or(0));
        }
        let with_count = |(id, channel): (i64, Channel)| channel.info(counts.get(&id).copied().unwrap_or(0));
        Ok(channels.into_iter().map(with_count).collect())
    };
    count().map_err(|error| damaged(path, &error))
}

/// Opens a file so that nothing is written, neither to it nor beside it.
fn open(path: &Path) -> Result<Connection, BagError> {
    let io_error = |source| BagError::Io { path: path.to_path_buf(), action: "open it", source };
    if files::open(path).and_then(|file| file.metadata()).map_err(io_error)?.len() == 0 {
        return Err(unreadable(path, "found an empty file"));
    }
    for ending in ["-wal", "-journal"] {
        let mut beside = path.as_os_str().to_owned();
        beside.push(ending);
        if std::fs::metadata(&beside).is_ok_and(|found| found.len() > 0) {
            let beside = Path::new(&beside).display().to_string();
            return Err(unreadable(
                path,
                format!(
                    "its last messages are still in '{beside}', since the recorder was killed or still runs; let SQLite put \
                     them in place with: sqlite3 FILE 'PRAGMA wal_checkpoint(TRUNCATE)'"
                ),
            ));
        }
    }
    let connect = || -> rusqlite::Result<Connection> {
        let flags =
            OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let database = Connection::open_with_flags(uri(path), flags)?;
        database
            .set_limit(Limit::SQLITE_LIMIT_LENGTH, i32::try_from(MAX_MESSAGE_BYTES).unwrap_or(i32::MAX))?;
        database.pragma_update(None, "trusted_schema", false)?;
        database.pragma_update(None, "cell_size_check", true)?;
        Ok(database)
    };
    let database = connect().map_err(|error| damaged(path, &error))?;
    // Only plain tables: a view may compute for ever.
    let count = "SELECT COUNT(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('topics', 'messages') \
                 AND sql NOT LIKE 'CREATE VIRTUAL%'";
    let num_tables: i64 =
        database.query_row(count, [], |row| row.get(0)).map_err(|error| damaged(path, &error))?;
    if num_tables == 2 {
        Ok(database)
    } else {
        Err(unreadable(path, "found a database without the tables 'topics' and 'messages'"))
    }
}

/// Whether the file has as many bytes as its head says. SQLite itself finds out only where it reads a page that is missing.
///
/// Source: the database file format, section 1.3.
fn size_fault(path: &Path) -> Option<String> {
    const HEAD_BYTES: u64 = 100;
    let file = files::open(path).ok()?;
    let found = file.metadata().ok()?.len();
    let mut head = Vec::new();
    file.take(HEAD_BYTES).read_to_end(&mut head).ok()?;
    let number = |at: usize| head.get(at..at + 4)?.try_into().ok().map(u32::from_be_bytes);
    let page_bytes = match number(16)? >> 16 {
        1 => 65536,
        bytes => u64::from(bytes),
    };
    // Programs before 2010 do not keep the number of pages up to date.
    let is_known = number(24)? == number(92)?;
    let expected = page_bytes * u64::from(number(28)?);
    (is_known && expected > 0 && expected != found)
        .then(|| format!("expected a file of {expected} bytes, found {found} (was the recording cut off?)"))
}

/// A file as SQLite wants it to be named, so that it is taken as one that nobody changes.
fn uri(path: &Path) -> String {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut uri = String::from("file:");
    for byte in absolute.as_os_str().as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"/-_.~".contains(byte) {
            uri.push(char::from(*byte));
        } else {
            // Writing to a string cannot fail.
            let _ = write!(uri, "%{byte:02X}");
        }
    }
    uri + "?immutable=1"
}

/// The topics by their numbers.
fn channels(database: &Connection) -> rusqlite::Result<BTreeMap<i64, Channel>> {
    let definitions = definitions(database)?;
    let has = |column: &str| database.column_exists(Some("main"), "topics", column);
    // Missing before version 2.
    let qos = if has("offered_qos_profiles")? { "coalesce(offered_qos_profiles, '')" } else { "''" };
    let hash = if has("type_description_hash")? { "coalesce(type_description_hash, '')" } else { "''" };
    let query = format!("SELECT id, name, type, serialization_format, {qos}, {hash} FROM topics");
    let mut statement = database.prepare(&query)?;
    let rows = statement.query_map([], |row| {
        let (name, type_name): (String, String) = (row.get(1)?, row.get(2)?);
        let mut metadata = BTreeMap::from([("offered_qos_profiles".to_string(), row.get::<_, String>(4)?)]);
        let hash: String = row.get(5)?;
        if !hash.is_empty() {
            metadata.insert("topic_type_hash".into(), hash);
        }
        // Before Dashing types were written without the part 'msg'.
        let type_name = match type_name.split_once('/') {
            Some((package, message)) if !message.contains('/') => format!("{package}/msg/{message}"),
            _ => type_name,
        };
        let known = || schemas::definition(&type_name).map(|text| ("ros2msg".to_string(), text.into_bytes()));
        let found = definitions.get(&type_name).cloned().or_else(known);
        // Without a definition the type is at least named.
        let (schema_encoding, schema) = found.unwrap_or_default();
        let channel = Channel {
            topic: name,
            type_name,
            message_encoding: row.get(3)?,
            schema_encoding,
            schema,
            metadata,
        };
        Ok((row.get(0)?, channel))
    })?;
    rows.collect()
}

/// Definitions of message types, in files since Iron.
fn definitions(database: &Connection) -> rusqlite::Result<BTreeMap<String, (String, Vec<u8>)>> {
    let table = "SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = 'message_definitions' \
                 AND sql NOT LIKE 'CREATE VIRTUAL%'";
    if database.query_row(table, [], |_| Ok(())).optional()?.is_none() {
        return Ok(BTreeMap::new());
    }
    let query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions";
    let mut statement = database.prepare(query)?;
    let rows = statement.query_map([], |row| {
        let text: String = row.get(2)?;
        Ok((row.get(0)?, (row.get(1)?, text.into_bytes())))
    })?;
    rows.collect()
}

fn unreadable(path: &Path, reason: impl Into<String>) -> BagError {
    BagError::Unreadable {
        path: path.to_path_buf(),
        expected: "a recording of rosbag2 in SQLite (.db3)",
        reason: reason.into(),
    }
}

fn damaged(path: &Path, error: &rusqlite::Error) -> BagError {
    unreadable(path, error.to_string())
}
