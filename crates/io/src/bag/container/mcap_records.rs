//! The records of an MCAP file.
//!
//! Source: the MCAP specification, version 0. Records are taken apart by the crate `mcap`; where they begin and end is worked out
//! here, since the crate's readers compute with lengths of damaged chunks before they check them.

use std::{
    fs::File,
    io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
};

use mcap::records::{Record, op};
use visloc_core::files;

use super::{DamagedBag, MAX_MESSAGE_BYTES, read_bytes, unpack};

/// First and last bytes of a file.
pub(super) const MAGIC: &[u8] = mcap::MAGIC;
/// How much is read from the file at once, bytes.
const READ_BYTES: usize = 256 << 10;
/// A record's opcode and length.
const PREFIX_BYTES: u64 = 9;
/// The footer's content: start of the summary, start of its offsets, checksum.
const FOOTER_BYTES: u64 = 20;
/// Longest name of a compression that is believed, bytes.
const MAX_NAME_BYTES: usize = 64;

/// The records of a file, those of chunks included. Memory is bounded by the longest record.
pub(super) struct Records {
    path: PathBuf,
    file: BufReader<File>,
    file_bytes: u64,
    /// Where the next record of the file begins; within a chunk, where the chunk ends.
    position: u64,
    chunk: Option<Chunk>,
    buffer: Vec<u8>,
    /// Attachments that were passed over so far.
    pub num_attachments: usize,
    has_begun: bool,
    is_done: bool,
}

/// The chunk that is being read.
struct Chunk {
    /// Unpacks; `None` if the records stand in the file as they are.
    unpacker: Option<Box<dyn Read + Send>>,
    num_left: u64,
    checksum: crc32fast::Hasher,
    saved_checksum: u32,
}

/// What ended the reading of a record.
enum Stop {
    Io(io::Error),
    Damage(String),
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl Records {
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = files::open(path)?;
        Ok(Self {
            path: path.to_path_buf(),
            file_bytes: file.metadata()?.len(),
            file: BufReader::with_capacity(READ_BYTES, file),
            position: 0,
            chunk: None,
            buffer: Vec::new(),
            num_attachments: 0,
            has_begun: false,
            is_done: false,
        })
    }

    /// Goes to the summary at the end. Whether there is one.
    pub fn go_to_summary(&mut self) -> io::Result<bool> {
        let tail_bytes = PREFIX_BYTES + FOOTER_BYTES + MAGIC.len() as u64;
        let Some(footer_at) = self.file_bytes.checked_sub(tail_bytes) else { return Ok(false) };
        let mut tail = Vec::new();
        self.file.seek(SeekFrom::Start(footer_at))?;
        read_bytes(&mut self.file, (PREFIX_BYTES + FOOTER_BYTES) as usize, &mut tail)?;
        let Ok(Record::Footer(footer)) = mcap::parse_record(tail[0], &tail[PREFIX_BYTES as usize..]) else {
            return Ok(false);
        };
        if footer.summary_start == 0 || footer.summary_start >= footer_at {
            return Ok(false);
        }
        self.position = self.file.seek(SeekFrom::Start(footer.summary_start))?;
        self.has_begun = true;
        Ok(true)
    }

    /// The next schema, channel, message or statistics. `None` at the end of the file; after damage that cannot be passed too.
    pub fn next_record(&mut self) -> Option<Result<Record<'_>, DamagedBag>> {
        let mut opcode = None;
        while opcode.is_none() && !self.is_done {
            match self.read_next() {
                Ok(found) => opcode = found,
                Err(stop) => return Some(Err(self.damage(stop))),
            }
        }
        let record = mcap::parse_record(opcode?, &self.buffer);
        Some(record.map_err(|error| DamagedBag {
            path: self.path.clone(),
            place: format!("byte {}", self.position),
            reason: format!("expected a valid MCAP record, found damage: {error}"),
            is_recoverable: true,
        }))
    }

    /// Reads the next record; gives its opcode if it is one of those that are needed.
    fn read_next(&mut self) -> Result<Option<u8>, Stop> {
        if !self.has_begun {
            self.read_magic()?;
            self.has_begun = true;
        }
        if self.chunk.is_some() { self.read_in_chunk() } else { self.read_in_file() }
    }

    fn read_magic(&mut self) -> Result<(), Stop> {
        self.expect_in_file(MAGIC.len() as u64)?;
        read_bytes(&mut self.file, MAGIC.len(), &mut self.buffer)?;
        if self.buffer != MAGIC {
            return Err(Stop::Damage("expected the mark of an MCAP file, found other bytes".into()));
        }
        self.position += MAGIC.len() as u64;
        Ok(())
    }

    fn read_in_file(&mut self) -> Result<Option<u8>, Stop> {
        self.expect_in_file(PREFIX_BYTES)?;
        let (opcode, num_bytes) = read_prefix(&mut self.file)?;
        self.position += PREFIX_BYTES;
        self.expect_in_file(if opcode == op::CHUNK { 0 } else { num_bytes })?;
        match opcode {
            op::CHUNK => {
                let end = self.position.checked_add(num_bytes).ok_or_else(|| too_long(num_bytes))?;
                self.chunk = Some(self.open_chunk(num_bytes)?);
                self.position = end;
                Ok(None)
            }
            _ if is_needed(opcode) => {
                self.position += num_bytes;
                read_bytes(&mut self.file, believed(num_bytes)?, &mut self.buffer)?;
                Ok(Some(opcode))
            }
            op::FOOTER => {
                self.position += num_bytes;
                self.file.seek(SeekFrom::Start(self.position))?;
                self.read_magic()?;
                self.is_done = true;
                match self.file_bytes - self.position {
                    0 => Ok(None),
                    more => {
                        Err(Stop::Damage(format!("expected the end of the file, found {more} more bytes")))
                    }
                }
            }
            _ => {
                self.num_attachments += usize::from(opcode == op::ATTACHMENT);
                self.position += num_bytes;
                self.file.seek_relative(i64::try_from(num_bytes).map_err(|_| too_long(num_bytes))?)?;
                Ok(None)
            }
        }
    }

    /// The head of a chunk: times, sizes, checksum, compression.
    fn open_chunk(&mut self, num_bytes: u64) -> Result<Chunk, Stop> {
        const SIZES_BYTES: usize = 8 + 8 + 8 + 4 + 4;
        let outside = || Stop::Damage(format!("a chunk of {num_bytes} bytes has no room for its own head"));
        read_bytes(&mut self.file, SIZES_BYTES, &mut self.buffer)?;
        let num_unpacked = u64_at(&self.buffer, 16);
        let (saved_checksum, name_bytes) = (u32_at(&self.buffer, 24), u32_at(&self.buffer, 28) as usize);
        if name_bytes > MAX_NAME_BYTES {
            return Err(Stop::Damage(format!(
                "expected the name of a compression, found {name_bytes} bytes"
            )));
        }
        read_bytes(&mut self.file, name_bytes + 8, &mut self.buffer)?;
        let num_packed = u64_at(&self.buffer, name_bytes);
        let head_bytes = (SIZES_BYTES + name_bytes + 8) as u64;
        num_bytes.checked_sub(head_bytes).filter(|room| *room >= num_packed).ok_or_else(outside)?;
        let unpacker: Option<Box<dyn Read + Send>> = match &self.buffer[..name_bytes] {
            b"" => None,
            name @ (b"zstd" | b"lz4") => {
                // Another reader of the same file; this one goes on behind the chunk.
                let mut file = self.file.get_ref().try_clone()?;
                file.seek(SeekFrom::Start(self.position + head_bytes))?;
                let packed = BufReader::with_capacity(READ_BYTES, file.take(num_packed));
                Some(if name == b"zstd" { unpack::zstd(packed)? } else { unpack::lz4(packed)? })
            }
            name => {
                let name = String::from_utf8_lossy(name);
                return Err(Stop::Damage(format!("expected chunks packed with zstd or lz4, found '{name}'")));
            }
        };
        let num_left = if unpacker.is_some() { num_unpacked } else { num_packed };
        Ok(Chunk { unpacker, num_left, checksum: crc32fast::Hasher::new(), saved_checksum })
    }

    fn read_in_chunk(&mut self) -> Result<Option<u8>, Stop> {
        let Some(chunk) = &mut self.chunk else { return Ok(None) };
        if chunk.num_left == 0 {
            let (saved, computed) = (chunk.saved_checksum, chunk.checksum.clone().finalize());
            self.leave_chunk()?;
            if saved != 0 && saved != computed {
                return Err(Stop::Damage(format!(
                    "checksum of a chunk is {computed:08x}, expected {saved:08x}: some messages before this are damaged"
                )));
            }
            return Ok(None);
        }
        let mut input: &mut dyn Read = match &mut chunk.unpacker {
            Some(unpacker) => unpacker,
            None => &mut self.file,
        };
        let mut prefix = [0; PREFIX_BYTES as usize];
        input.read_exact(&mut prefix)?;
        let (opcode, num_bytes) = (prefix[0], u64_at(&prefix, 1));
        let left = chunk.num_left.checked_sub(PREFIX_BYTES).and_then(|left| left.checked_sub(num_bytes));
        chunk.num_left = left.ok_or_else(|| {
            let room = chunk.num_left.saturating_sub(PREFIX_BYTES);
            Stop::Damage(format!(
                "expected a record of at most {room} bytes, the rest of its chunk, found one of {num_bytes}"
            ))
        })?;
        read_bytes(&mut input, believed(num_bytes)?, &mut self.buffer)?;
        chunk.checksum.update(&prefix);
        chunk.checksum.update(&self.buffer);
        Ok(is_needed(opcode).then_some(opcode))
    }

    /// Goes on behind the chunk.
    fn leave_chunk(&mut self) -> io::Result<()> {
        self.chunk = None;
        self.file.seek(SeekFrom::Start(self.position)).map(drop)
    }

    /// That so many bytes are still there.
    fn expect_in_file(&self, num_bytes: u64) -> Result<(), Stop> {
        let left = self.file_bytes.saturating_sub(self.position);
        if num_bytes <= left {
            return Ok(());
        }
        let end = "(was the recording cut off?)";
        Err(Stop::Io(io::Error::new(
            ErrorKind::UnexpectedEof,
            format!(
                "expected at least {} more bytes of a record or the end mark of MCAP, found the end of the file {end}",
                num_bytes - left
            ),
        )))
    }

    /// What to tell, and whether reading goes on: behind a damaged chunk that is complete.
    fn damage(&mut self, stop: Stop) -> DamagedBag {
        let is_behind_end = self.position >= self.file_bytes;
        let was_in_chunk = self.chunk.is_some();
        let is_checksum = matches!(&stop, Stop::Damage(reason) if reason.starts_with("checksum"));
        // Only what does not belong to the recording any more is wrong then.
        let is_complete = self.is_done;
        let goes_on = (was_in_chunk && !is_behind_end && self.leave_chunk().is_ok()) || is_checksum;
        self.is_done = !goes_on;
        let (place, reason) = match stop {
            Stop::Damage(reason) => (self.position.min(self.file_bytes), reason),
            Stop::Io(_) if was_in_chunk && is_behind_end => (
                self.file_bytes,
                "expected more bytes of a record, found the end of the file (was the recording cut off?)"
                    .into(),
            ),
            Stop::Io(error) if was_in_chunk => {
                (self.position, format!("expected a valid chunk of records, found damage: {error}"))
            }
            Stop::Io(error) if error.kind() == ErrorKind::UnexpectedEof => {
                (self.file_bytes, error.to_string())
            }
            Stop::Io(error) => (self.position, format!("cannot read on: {error}")),
        };
        DamagedBag {
            path: self.path.clone(),
            place: format!("byte {place}"),
            reason,
            is_recoverable: goes_on || is_complete,
        }
    }
}

fn read_prefix(input: &mut impl Read) -> io::Result<(u8, u64)> {
    let mut prefix = [0; PREFIX_BYTES as usize];
    input.read_exact(&mut prefix)?;
    Ok((prefix[0], u64_at(&prefix, 1)))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..at + 8).and_then(|bytes| bytes.try_into().ok()).map_or(0, u64::from_le_bytes)
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).map_or(0, u32::from_le_bytes)
}

fn too_long(num_bytes: u64) -> Stop {
    Stop::Damage(format!(
        "expected a record of at most {} MiB, found one of {num_bytes} bytes",
        MAX_MESSAGE_BYTES >> 20
    ))
}

fn believed(num_bytes: u64) -> Result<usize, Stop> {
    usize::try_from(num_bytes)
        .ok()
        .filter(|num_bytes| *num_bytes <= MAX_MESSAGE_BYTES)
        .ok_or_else(|| too_long(num_bytes))
}

fn is_needed(opcode: u8) -> bool {
    matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::STATISTICS)
}
