//! What stands where in a ROS 1 bag: by its index, or by a walk through the file.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom},
    path::Path,
};

use visloc_core::files;

use super::{
    super::{
        read_bytes,
        ros1_records::{op, read_header, wrong},
    },
    ChunkPlace, ChunkRecord, ConnectionRecord, MAGIC, parse_chunk, read_chunk,
};
use crate::bag::BagError;

/// First line of a file.
const VERSION: &[u8] = b"#ROSBAG V2.0\n";
/// Longest record of a connection that is believed, bytes.
const MAX_CONNECTION_BYTES: usize = 16 << 20;

/// What a file has where.
#[derive(Default)]
pub(super) struct Layout {
    pub connections: BTreeMap<u32, ConnectionRecord>,
    pub chunks: Vec<ChunkPlace>,
    pub counts: BTreeMap<u32, u64>,
    /// Why there may be more than was found, and where.
    pub end: Option<String>,
    pub end_at: u64,
}

pub(super) fn read_layout(path: &Path) -> Result<(BufReader<File>, Layout), BagError> {
    let io_error = |source| BagError::Io { path: path.to_path_buf(), action: "read it", source };
    let unreadable = |reason: String| BagError::Unreadable {
        path: path.to_path_buf(),
        expected: "a ROS 1 bag (.bag)",
        reason,
    };
    let mut file = BufReader::new(files::open(path).map_err(io_error)?);
    let mut first_line = Vec::new();
    (&mut file).take(VERSION.len() as u64).read_to_end(&mut first_line).map_err(io_error)?;
    if first_line != VERSION {
        let found = match first_line.strip_prefix(MAGIC) {
            Some(version) => {
                let version = String::from_utf8_lossy(version);
                format!(
                    "found version {}, expected 2.0; 'rosbag migrate' of ROS 1 converts it",
                    version.trim()
                )
            }
            None if first_line.is_empty() => "found an empty file".into(),
            None => "found other bytes at its beginning".into(),
        };
        return Err(unreadable(found));
    }
    let header = read_header(&mut file).map_err(|error| unreadable(error.to_string()))?;
    let Some((header, num_bytes)) = header.filter(|(header, _)| header.op() == op::BAG_HEADER) else {
        return Err(unreadable("found no header of a bag behind the first line".into()));
    };
    let file_bytes = file.get_ref().metadata().map_err(io_error)?.len();
    let index_at = header.u64("index_pos").unwrap_or(0);
    if index_at > 0 && index_at <= file_bytes {
        let indexed = file.seek(SeekFrom::Start(index_at)).and_then(|_| read_index(&mut file));
        if let Ok(layout) = indexed {
            return Ok((file, layout));
        }
    }
    let begin = VERSION.len() as u64;
    file.seek(SeekFrom::Start(begin)).map_err(io_error)?;
    let _ = read_header(&mut file).map_err(io_error)?;
    file.seek_relative(i64::from(num_bytes)).map_err(io_error)?;
    let layout = scan(&mut file, file_bytes);
    match &layout.end {
        Some(reason) if layout.chunks.is_empty() => Err(unreadable(reason.clone())),
        _ => Ok((file, layout)),
    }
}

/// The index at the end of a complete file.
fn read_index(file: &mut BufReader<File>) -> io::Result<Layout> {
    let mut layout = Layout::default();
    let mut data = Vec::new();
    while let Some((header, num_bytes)) = read_header(file)? {
        let num_bytes = num_bytes as usize;
        if num_bytes > MAX_CONNECTION_BYTES {
            return Err(wrong(format!("expected an index, found a record of {num_bytes} bytes")));
        }
        read_bytes(file, num_bytes, &mut data)?;
        match header.op() {
            op::CONNECTION => {
                let (id, record) = ConnectionRecord::parse(&header, &data).map_err(wrong)?;
                layout.connections.entry(id).or_insert(record);
            }
            op::CHUNK_INFO => {
                let (at, start_nanos) =
                    (header.u64("chunk_pos").map_err(wrong)?, header.nanos("start_time").map_err(wrong)?);
                layout.chunks.push(ChunkPlace { start_nanos, at });
                for pair in data.chunks_exact(8) {
                    let value = |bytes: &[u8]| bytes.try_into().map(u32::from_le_bytes).unwrap_or(0);
                    *layout.counts.entry(value(&pair[..4])).or_default() += u64::from(value(&pair[4..]));
                }
            }
            other => return Err(wrong(format!("expected an index, found a record of kind {other}"))),
        }
    }
    Ok(layout)
}

/// Goes through a file without index, as a recorder that was killed leaves it.
fn scan(file: &mut BufReader<File>, file_bytes: u64) -> Layout {
    let mut layout = Layout::default();
    loop {
        let at = match file.stream_position() {
            Ok(at) => at,
            Err(error) => return Layout { end: Some(error.to_string()), ..layout },
        };
        let found = match scan_record(file, at, file_bytes, &mut layout) {
            Ok(true) => continue,
            Ok(false) => "expected an index, found the end of the file (was the recording cut off?)".into(),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                "expected more bytes of a record, found the end of the file (was the recording cut off?)"
                    .into()
            }
            Err(error) => error.to_string(),
        };
        return Layout { end: Some(found), end_at: at, ..layout };
    }
}

/// Takes the next record into the layout. Whether there was one.
fn scan_record(
    file: &mut BufReader<File>,
    at: u64,
    file_bytes: u64,
    layout: &mut Layout,
) -> io::Result<bool> {
    let Some((header, num_bytes)) = read_header(file)? else { return Ok(false) };
    let end = file.stream_position()? + u64::from(num_bytes);
    if header.op() == op::CHUNK {
        let unpacked = read_chunk(file, at)?;
        let mut start_nanos = None;
        // What is wrong in the chunk is told when its messages are read.
        let _ = parse_chunk(&unpacked.bytes, |record| match record {
            ChunkRecord::Connection(id, record) => {
                layout.connections.entry(id).or_insert(record);
            }
            ChunkRecord::Message(entry) => {
                *layout.counts.entry(entry.connection).or_default() += 1;
                start_nanos = Some(start_nanos.map_or(entry.nanos, |start: u64| start.min(entry.nanos)));
            }
        });
        if let Some(start_nanos) = start_nanos {
            layout.chunks.push(ChunkPlace { start_nanos, at });
        }
    }
    if end > file_bytes {
        return Err(ErrorKind::UnexpectedEof.into());
    }
    file.seek(SeekFrom::Start(end))?;
    Ok(true)
}
