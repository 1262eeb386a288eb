//! Sections with check sums. `docs/map-files.md` has the layout.
//!
//! Nothing is allocated because a file asks for it: what is stored lies in the file, and what is unpacked has a bound.

use std::io::{self, Read, Seek, SeekFrom, Write};

use flate2::{Compression, read::DeflateDecoder, write::DeflateEncoder};

use crate::VmapError;

/// The newest version of the layout that is read, and the one that is written.
pub const FORMAT_VERSION: u32 = 1;
/// Longest file that is read, bytes: some ten thousand keyframes.
pub const MAX_FILE_BYTES: u64 = 1 << 30;
/// Longest section, unpacked, bytes.
const MAX_SECTION_BYTES: u64 = 1 << 28;

/// First bytes of a file. A transfer that changes the ends of lines changes them.
const MAGIC: [u8; 8] = *b"\x8fVMAP\r\n\x1a";
/// Bytes of a head without its entries: magic, version, number of entries.
const HEAD_BYTES: usize = 16;
/// Bytes of an entry.
const ENTRY_BYTES: usize = 40;
/// Most bytes that one packed byte unpacks to. Source: RFC 1951, matches of 258 bytes take at least two bits.
const MAX_RATIO: u64 = 1032;

/// What a section holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind(pub [u8; 4]);

/// A section to be written.
pub struct Section {
    /// What it holds.
    pub kind: Kind,
    /// Its number among those of the kind.
    pub number: u32,
    /// What is written.
    pub stored: Vec<u8>,
    /// Length of the content.
    num_bytes: usize,
    is_packed: bool,
}

impl Section {
    /// A section of numbers, which is packed.
    pub fn of_numbers(kind: Kind, number: u32, content: &[u8]) -> Self {
        Self { kind, number, num_bytes: content.len(), stored: pack(content), is_packed: true }
    }

    /// A section that is packed in a way of its own.
    pub fn as_it_is(kind: Kind, number: u32, stored: Vec<u8>) -> Self {
        Self { kind, number, num_bytes: stored.len(), stored, is_packed: false }
    }
}

/// Writes a file.
pub fn assemble(sections: &[Section], file: &mut impl Write) -> io::Result<()> {
    let head_bytes = HEAD_BYTES + sections.len() * ENTRY_BYTES + 4;
    let (mut head, mut offset) = (Vec::with_capacity(head_bytes), head_bytes);
    head.extend(MAGIC);
    head.extend(FORMAT_VERSION.to_le_bytes());
    head.extend((sections.len() as u32).to_le_bytes());
    for section in sections {
        head.extend(section.kind.0);
        head.extend(section.number.to_le_bytes());
        head.extend((offset as u64).to_le_bytes());
        head.extend((section.stored.len() as u64).to_le_bytes());
        head.extend((section.num_bytes as u64).to_le_bytes());
        head.extend(u32::from(section.is_packed).to_le_bytes());
        head.extend(crc32fast::hash(&section.stored).to_le_bytes());
        offset += section.stored.len();
    }
    head.extend(crc32fast::hash(&head).to_le_bytes());
    file.write_all(&head)?;
    sections.iter().try_for_each(|section| file.write_all(&section.stored))?;
    // The head again, for the case that the first one is damaged.
    file.write_all(&head)?;
    file.write_all(&(head.len() as u64).to_le_bytes())
}

fn pack(content: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
    // Writing into memory does not fail.
    let _ = encoder.write_all(content);
    encoder.finish().unwrap_or_default()
}

/// A section of a file.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// What it holds.
    pub kind: Kind,
    /// Its number among those of the kind.
    pub number: u32,
    offset: u64,
    stored_bytes: u64,
    content_bytes: u64,
    is_packed: bool,
    crc: u32,
}

/// The sections of a file, of which only what is asked for is read: a large map is not in memory beside its file.
pub struct Sections<F> {
    file: F,
    /// In the order of the file.
    pub entries: Vec<Entry>,
    /// What is wrong with the first head, if the second one had to be used.
    pub head_damage: Option<String>,
}

impl<F: Read + Seek> Sections<F> {
    /// The sections of a file.
    pub fn read(mut file: F) -> Result<Self, VmapError> {
        let num_bytes = file.seek(SeekFrom::End(0))?;
        let start = bytes_at(&mut file, 0, HEAD_BYTES as u64)?;
        let is_ours = start.starts_with(&MAGIC);
        // An entry more than there are is longer than the check sum.
        let most = Fields(&start).count().map_or(0, |count| (u64::from(count) + 1) * ENTRY_BYTES as u64);
        let first = read_head(&bytes_at(&mut file, 0, HEAD_BYTES as u64 + most)?, num_bytes);
        let (entries, head_damage) = match first {
            Ok(entries) => (entries, None),
            Err(HeadError::TooNew(found)) => {
                return Err(VmapError::TooNew { known: FORMAT_VERSION, found });
            }
            Err(HeadError::Damaged(reason)) => {
                match second_head(&mut file, num_bytes)?.map(|head| read_head(&head, num_bytes)) {
                    Some(Ok(entries)) => (entries, Some(reason)),
                    _ if is_ours => {
                        return Err(VmapError::Section { section: "head".to_owned(), reason });
                    }
                    _ => return Err(VmapError::Foreign),
                }
            }
        };
        Ok(Self { file, entries, head_damage })
    }

    /// The content of a section, or what is wrong with it.
    pub fn content(&mut self, entry: &Entry) -> Result<Vec<u8>, String> {
        let stored = bytes_at(&mut self.file, entry.offset, entry.stored_bytes);
        let stored = stored.map_err(|error| error.to_string())?;
        if stored.len() as u64 != entry.stored_bytes {
            return Err("it lies outside of the file".to_owned());
        }
        if crc32fast::hash(&stored) != entry.crc {
            return Err("its check sum is wrong".to_owned());
        }
        let most =
            if entry.is_packed { entry.stored_bytes.saturating_mul(MAX_RATIO) } else { entry.stored_bytes };
        if entry.content_bytes > most.min(MAX_SECTION_BYTES) {
            return Err(format!(
                "expected at most {} bytes, found {}",
                most.min(MAX_SECTION_BYTES),
                entry.content_bytes
            ));
        }
        if !entry.is_packed {
            return Ok(stored);
        }
        let mut content = Vec::new();
        let unpacked =
            DeflateDecoder::new(&stored[..]).take(entry.content_bytes + 1).read_to_end(&mut content);
        match unpacked {
            Ok(_) if content.len() as u64 == entry.content_bytes => Ok(content),
            Ok(_) => Err("it has another length than expected".to_owned()),
            Err(error) => Err(error.to_string()),
        }
    }
}

/// So many bytes of a file, fewer where it ends before.
fn bytes_at(file: &mut (impl Read + Seek), offset: u64, num: u64) -> io::Result<Vec<u8>> {
    let left = file.seek(SeekFrom::End(0))?.saturating_sub(offset);
    file.seek(SeekFrom::Start(offset))?;
    let mut bytes = Vec::with_capacity(usize::try_from(num.min(left)).unwrap_or(0));
    file.take(num).read_to_end(&mut bytes)?;
    Ok(bytes)
}

enum HeadError {
    TooNew(u32),
    Damaged(String),
}

/// The copy of the head at the end of a file.
fn second_head(file: &mut (impl Read + Seek), num_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    let Some(end) = num_bytes.checked_sub(8) else { return Ok(None) };
    let length = Fields(&bytes_at(file, end, 8)?).u64();
    let start = length.and_then(|length| Some((end.checked_sub(length)?, length)));
    start.map(|(start, length)| bytes_at(file, start, length)).transpose()
}

/// Reads the head at the start of some bytes of a file of a length.
fn read_head(bytes: &[u8], file_bytes: u64) -> Result<Vec<Entry>, HeadError> {
    let damaged = |reason: &str| HeadError::Damaged(reason.to_owned());
    let mut fields = Fields(bytes);
    if fields.take::<8>() != Some(MAGIC) {
        return Err(damaged("its mark is wrong"));
    }
    let (Some(version), Some(count)) = (fields.u32(), fields.u32()) else {
        return Err(damaged("it is cut off"));
    };
    let num_bytes = (count as usize).saturating_mul(ENTRY_BYTES).saturating_add(HEAD_BYTES);
    let Some((head, rest)) = bytes.split_at_checked(num_bytes) else {
        return Err(damaged("it is cut off"));
    };
    if Fields(rest).u32() != Some(crc32fast::hash(head)) {
        return Err(damaged("its check sum is wrong"));
    }
    if version > FORMAT_VERSION {
        return Err(HeadError::TooNew(version));
    }
    let entries: Option<Vec<Entry>> = (0..count).map(|_| fields.entry()).collect();
    let entries = entries.ok_or(damaged("it is cut off"))?;
    // Of a file that was cut off, what is left can be used.
    let ends_inside = |e: &&Entry| e.offset.checked_add(e.stored_bytes).is_some_and(|end| end <= file_bytes);
    let mut lengths = entries.iter().filter(ends_inside).map(|entry| entry.stored_bytes);
    let total = lengths.try_fold(0_u64, u64::checked_add);
    // Sections that lie in each other could be unpacked to anything.
    if total.is_none_or(|total| total > file_bytes) {
        return Err(damaged("its sections are longer than the file"));
    }
    Ok(entries)
}

/// Fields of fixed lengths, one after the other.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (field, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*field)
    }

    /// The number of entries in a head.
    fn count(&mut self) -> Option<u32> {
        self.take::<12>()?;
        self.u32()
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn entry(&mut self) -> Option<Entry> {
        Some(Entry {
            kind: Kind(self.take()?),
            number: self.u32()?,
            offset: self.u64()?,
            stored_bytes: self.u64()?,
            content_bytes: self.u64()?,
            is_packed: self.u32()? != 0,
            crc: self.u32()?,
        })
    }
}
