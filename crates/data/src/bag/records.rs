//! The records of one MCAP file, read piece by piece.

use std::{
    fs::File,
    io::{self, Read},
    path::{Path, PathBuf},
};

use mcap::{
    McapError,
    records::Record,
    sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions},
};

/// Longest record that is believed, bytes: above any picture, below what a damaged length field asks for.
const MAX_RECORD_BYTES: usize = 256 << 20;
/// How much is read from the file at once, bytes.
const READ_BYTES: usize = 256 << 10;

/// Why the records of a file end early.
#[derive(Debug)]
pub(super) struct RecordError {
    pub path: PathBuf,
    /// Bytes of the file that were read.
    pub offset: u64,
    /// What was expected and what was found.
    pub reason: String,
    /// Whether reading can go on behind it.
    pub is_recoverable: bool,
}

/// Streams the records of a file. Memory is bounded by the longest record.
pub(super) struct RecordStream {
    path: PathBuf,
    file: File,
    reader: LinearReader,
    offset: u64,
    is_done: bool,
}

impl RecordStream {
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let options = LinearReaderOptions::default()
            .with_record_length_limit(MAX_RECORD_BYTES)
            .with_validate_chunk_crcs(true);
        Ok(Self {
            path: path.to_path_buf(),
            file: File::open(path)?,
            reader: LinearReader::new_with_options(options),
            offset: 0,
            is_done: false,
        })
    }

    /// Hands the next record that `take` is interested in to it and returns what it makes of it. `None` at the end of
    /// the file; after an error that is not recoverable too.
    pub(super) fn next_with<T>(
        &mut self,
        mut take: impl FnMut(Record<'_>) -> Option<T>,
    ) -> Option<Result<T, RecordError>> {
        let mut num_missing = 0;
        while !self.is_done {
            match self.reader.next_event() {
                None => self.is_done = true,
                Some(Ok(LinearReadEvent::ReadRequest(num_bytes))) => {
                    num_missing = num_bytes;
                    if let Err(error) = self.read(num_bytes) {
                        return Some(Err(self.broken(format!("cannot read on: {error}"))));
                    }
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    if !is_needed(opcode) {
                        continue;
                    }
                    match mcap::parse_record(opcode, data) {
                        Ok(record) => {
                            if let Some(taken) = take(record) {
                                return Some(Ok(taken));
                            }
                        }
                        Err(error) => return Some(Err(self.broken(describe(&error, 0)))),
                    }
                }
                Some(Err(error)) => {
                    let is_recoverable = matches!(error, McapError::BadChunkCrc { .. });
                    let mut broken = self.broken(describe(&error, num_missing));
                    broken.is_recoverable = is_recoverable;
                    self.is_done = !is_recoverable;
                    return Some(Err(broken));
                }
            }
        }
        None
    }

    /// Feeds the reader at most what it asks for, in small steps: a damaged length must not reserve memory.
    fn read(&mut self, num_bytes: usize) -> io::Result<()> {
        let buffer = self.reader.insert(num_bytes.min(READ_BYTES));
        let num_read = loop {
            match self.file.read(buffer) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                other => break other?,
            }
        };
        self.reader.notify_read(num_read);
        self.offset += num_read as u64;
        Ok(())
    }

    fn broken(&mut self, reason: String) -> RecordError {
        self.is_done = true;
        RecordError { path: self.path.clone(), offset: self.offset, reason, is_recoverable: false }
    }
}

fn is_needed(opcode: u8) -> bool {
    use mcap::records::op;
    matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE)
}

fn describe(error: &McapError, num_missing: usize) -> String {
    match error {
        McapError::UnexpectedEof => format!(
            "expected at least {num_missing} more bytes of a record or the end mark of MCAP, found the end of the file \
             (was the recording cut off?)"
        ),
        McapError::BadMagic => "expected the mark of an MCAP file, found other bytes".into(),
        McapError::BadChunkCrc { saved, calculated } => format!(
            "checksum of a chunk is {calculated:08x}, expected {saved:08x}: some messages before this are damaged"
        ),
        other => format!("expected a valid MCAP record, found damage: {other}"),
    }
}
