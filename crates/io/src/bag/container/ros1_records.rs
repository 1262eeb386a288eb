//! The records of a ROS 1 bag.
//!
//! Source: the bag format, version 2.0 (wiki.ros.org/Bags/Format/2.0): a header of fields `name=value` and data, each behind its
//! length of 32 bits.

use std::{
    collections::BTreeMap,
    io::{self, Read},
};

use super::read_bytes;

/// What a record is.
pub(super) mod op {
    pub const MESSAGE: u8 = 2;
    pub const BAG_HEADER: u8 = 3;
    pub const CHUNK: u8 = 5;
    pub const CHUNK_INFO: u8 = 6;
    pub const CONNECTION: u8 = 7;
}

/// Longest header that is believed, bytes.
const MAX_HEADER_BYTES: usize = 1 << 20;

/// Fields by name.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(super) struct Fields(BTreeMap<String, Vec<u8>>);

impl Fields {
    /// Takes fields apart.
    ///
    /// # Errors
    /// What was expected and what was found.
    pub(super) fn parse(mut bytes: &[u8]) -> Result<Self, String> {
        let mut fields = BTreeMap::new();
        while !bytes.is_empty() {
            let field = bytes.split_first_chunk::<4>().and_then(|(length, rest)| {
                rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
            });
            let (field, rest) =
                field.ok_or("expected a field of a record, found one that is longer than its header")?;
            let equals =
                field.iter().position(|byte| *byte == b'=').ok_or("expected a field 'name=value'")?;
            fields
                .insert(String::from_utf8_lossy(&field[..equals]).into_owned(), field[equals + 1..].to_vec());
            bytes = rest;
        }
        Ok(Self(fields))
    }

    pub(super) fn get(&self, name: &str) -> Option<&[u8]> {
        self.0.get(name).map(Vec::as_slice)
    }

    pub(super) fn text(&self, name: &str) -> Option<String> {
        self.get(name).map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }

    pub(super) fn op(&self) -> u8 {
        self.get("op").and_then(|bytes| bytes.first().copied()).unwrap_or(0)
    }

    pub(super) fn u32(&self, name: &str) -> Result<u32, String> {
        self.get(name)
            .and_then(|bytes| bytes.try_into().ok())
            .map(u32::from_le_bytes)
            .ok_or_else(|| format!("expected a field '{name}' of 4 bytes"))
    }

    pub(super) fn u64(&self, name: &str) -> Result<u64, String> {
        self.get(name)
            .and_then(|bytes| bytes.try_into().ok())
            .map(u64::from_le_bytes)
            .ok_or_else(|| format!("expected a field '{name}' of 8 bytes"))
    }

    /// A time, nanoseconds.
    pub(super) fn nanos(&self, name: &str) -> Result<u64, String> {
        self.u64(name).map(|time| (time & 0xffff_ffff) * 1_000_000_000 + (time >> 32))
    }
}

/// Reads the header of the next record and the length of its data. `None` at the end.
pub(super) fn read_header(input: &mut impl Read) -> io::Result<Option<(Fields, u32)>> {
    let mut length = Vec::new();
    input.take(4).read_to_end(&mut length)?;
    if length.is_empty() {
        return Ok(None);
    }
    let length: [u8; 4] = length.try_into().map_err(|_| io::ErrorKind::UnexpectedEof)?;
    let num_bytes = usize::try_from(u32::from_le_bytes(length)).unwrap_or(usize::MAX);
    if num_bytes > MAX_HEADER_BYTES {
        return Err(wrong(format!("expected the header of a record, found one of {num_bytes} bytes")));
    }
    let mut header = Vec::new();
    read_bytes(input, num_bytes, &mut header)?;
    let fields = Fields::parse(&header).map_err(wrong)?;
    if fields.get("op").is_none() {
        // Such as zeros, which the system puts where a computer that crashed had not written yet.
        return Err(wrong("expected a record with a field 'op', found a header without".into()));
    }
    let mut data_bytes = [0; 4];
    input.read_exact(&mut data_bytes)?;
    Ok(Some((fields, u32::from_le_bytes(data_bytes))))
}

/// Damage that is no fault of the system.
pub(super) fn wrong(reason: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_by_hand() {
        let bytes = b"\x04\0\0\0op=\x05\x09\0\0\0size=\x02\0\0\0";
        let fields = Fields::parse(&bytes[..]).unwrap();
        assert_eq!((fields.op(), fields.u32("size").unwrap()), (5, 2));
        assert!(fields.u64("size").unwrap_err().contains("8 bytes"));
        for length in 1..bytes.len() {
            assert!(length == 8 || Fields::parse(&bytes[..length]).is_err(), "{length}");
        }
    }
}
