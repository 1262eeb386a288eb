//! Messages to pages, in recordings and between programs: a JSON header with binary arrays behind it.
//!
//! ```text
//! byte 0      kind: 1 scene, 2 state, 3 image, 4 input
//! byte 1      0, or 1 if what follows byte 8 is packed with DEFLATE; on the way to a page and in recordings
//! byte 2..4   0
//! byte 4..8   length of the header, unsigned 32 bit, little endian
//! header      JSON, padded with spaces so that the arrays begin at a multiple of 4
//! arrays      float32 little endian or bytes, each padded to a multiple of 4
//! ```
//!
//! The header's `arrays` says where each array lies: `{"name": [offset behind the header, number of elements, "f32" or "u8"]}`.

use std::{
    borrow::Cow,
    io::{Read as _, Write as _},
};

use flate2::{Compression, read::DeflateDecoder, write::DeflateEncoder};
use serde::Serialize;
use serde_json::{Map, Value};
use thiserror::Error;

/// Bytes before the header.
const PREFIX: usize = 8;
/// Byte that says whether a message is packed.
const PACKING: usize = 1;
const PACKED: u8 = 1;
/// A packed message that gets longer than this is damage, bytes.
const MAX_UNPACKED: u64 = 64 << 20;
/// Key of the header that lists the arrays.
const ARRAYS: &str = "arrays";

/// What a message tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum MessageKind {
    /// What stays: the world, the algorithms, their parameters.
    Scene = 1,
    /// What is true now.
    State = 2,
    /// A camera image with what belongs on it.
    Image = 3,
    /// What an algorithm was given, in recordings only.
    Input = 4,
}

/// Bytes that are not a message.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MessageError {
    /// The header is not JSON or not a table.
    #[error("message: expected a header of JSON, {reason}")]
    Header {
        /// What is wrong.
        reason: String,
    },
    /// It is too short or of no known kind.
    #[error("message of {num_bytes} bytes: expected {expected}")]
    Shape {
        /// Its length.
        num_bytes: usize,
        /// What it should have.
        expected: &'static str,
    },
}

/// Puts a message together.
#[derive(Debug)]
pub struct MessageBuilder {
    kind: MessageKind,
    header: Map<String, Value>,
    arrays: Map<String, Value>,
    body: Vec<u8>,
}

impl MessageBuilder {
    /// A message with a header, which has to be a table.
    ///
    /// # Errors
    /// If the header cannot be written as a JSON table.
    pub fn new(kind: MessageKind, header: &impl Serialize) -> Result<Self, MessageError> {
        let reason = |reason: String| MessageError::Header { reason };
        let value = serde_json::to_value(header).map_err(|error| reason(error.to_string()))?;
        let Value::Object(header) = value else { return Err(reason("found no table".to_owned())) };
        Ok(Self { kind, header, arrays: Map::new(), body: Vec::new() })
    }

    /// Adds numbers.
    pub fn floats(&mut self, name: &str, values: impl IntoIterator<Item = f64>) {
        let offset = self.body.len();
        self.body.extend(values.into_iter().flat_map(|value| (value as f32).to_le_bytes()));
        self.note(name, offset, (self.body.len() - offset) / 4, "f32");
    }

    /// Adds bytes.
    pub fn bytes(&mut self, name: &str, values: &[u8]) {
        let offset = self.body.len();
        self.body.extend_from_slice(values);
        self.body.resize(self.body.len().next_multiple_of(4), 0);
        self.note(name, offset, values.len(), "u8");
    }

    /// Adds arrays of another message.
    fn copy(&mut self, from: &Message, is_wanted: impl Fn(&str) -> bool) {
        for name in from.arrays.keys().filter(|name| is_wanted(name)) {
            match from.floats(name) {
                Some(values) if from.is_floats(name) => self.floats(name, values.into_iter().map(f64::from)),
                _ => self.bytes(name, from.bytes(name).unwrap_or_default()),
            }
        }
    }

    /// Adds to the header.
    pub(crate) fn field(&mut self, name: &str, value: Value) {
        self.header.insert(name.to_owned(), value);
    }

    fn note(&mut self, name: &str, offset: usize, count: usize, kind: &str) {
        self.arrays.insert(name.to_owned(), serde_json::json!([offset, count, kind]));
    }

    /// The bytes.
    pub fn finish(mut self) -> Vec<u8> {
        self.header.insert(ARRAYS.to_owned(), Value::Object(self.arrays));
        let mut header = Value::Object(self.header).to_string().into_bytes();
        header.resize(header.len().next_multiple_of(4), b' ');
        let mut out = Vec::with_capacity(PREFIX + header.len() + self.body.len());
        out.extend_from_slice(&[self.kind as u8, 0, 0, 0]);
        out.extend_from_slice(&u32::try_from(header.len()).unwrap_or(u32::MAX).to_le_bytes());
        out.extend(header);
        out.extend(self.body);
        out
    }
}

/// A message that was received or recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// What it tells.
    pub kind: MessageKind,
    /// Its header, without the list of arrays.
    pub header: Map<String, Value>,
    arrays: Map<String, Value>,
    body: Vec<u8>,
}

impl Message {
    /// Reads a message.
    ///
    /// # Errors
    /// If the bytes are cut off, of no known kind, or their header is not JSON.
    pub fn read(bytes: &[u8]) -> Result<Self, MessageError> {
        let shape = |expected| MessageError::Shape { num_bytes: bytes.len(), expected };
        let kind = match bytes.first() {
            Some(1) => MessageKind::Scene,
            Some(2) => MessageKind::State,
            Some(3) => MessageKind::Image,
            Some(4) => MessageKind::Input,
            _ => return Err(shape("a first byte from 1 to 4")),
        };
        let length = bytes.get(4..PREFIX).and_then(|length| length.try_into().ok()).map(u32::from_le_bytes);
        let length = length.ok_or_else(|| shape("a whole header"))? as usize;
        let content = unpacked(bytes).ok_or_else(|| shape("whole packed content"))?;
        let text = content.get(..length).ok_or_else(|| shape("a whole header"))?;
        let header = |reason: String| MessageError::Header { reason };
        let mut parsed: Map<String, Value> =
            serde_json::from_slice(text).map_err(|error| header(error.to_string()))?;
        let arrays = match parsed.remove(ARRAYS) {
            Some(Value::Object(arrays)) => arrays,
            _ => return Err(header("found no list of arrays".to_owned())),
        };
        let body = content.get(length..).unwrap_or_default().to_vec();
        Ok(Self { kind, header: parsed, arrays, body })
    }

    /// The bytes, with what has been changed in the header.
    pub fn write(self) -> Vec<u8> {
        self.into_builder().finish()
    }

    /// To add arrays.
    pub fn into_builder(self) -> MessageBuilder {
        let Self { kind, header, arrays, body } = self;
        MessageBuilder { kind, header, arrays, body }
    }

    /// The bytes of the same message with another content of one of its arrays of bytes, and without some of the others.
    pub(crate) fn with_bytes(&self, name: &str, bytes: &[u8], without: &[&str]) -> Vec<u8> {
        let mut builder = self.without(&[without, &[name]].concat());
        builder.bytes(name, bytes);
        builder.finish()
    }

    /// The same message without some of its arrays.
    pub(crate) fn without(&self, names: &[&str]) -> MessageBuilder {
        let mut builder = MessageBuilder {
            kind: self.kind,
            header: self.header.clone(),
            arrays: Map::new(),
            body: Vec::new(),
        };
        builder.copy(self, |name| !names.contains(&name));
        builder
    }

    /// The same message with those arrays of another one that it lacks.
    #[must_use]
    pub(crate) fn completed_by(self, other: &Self) -> Self {
        let known = self.arrays.clone();
        let mut builder = self.into_builder();
        builder.copy(other, |name| !known.contains_key(name));
        let MessageBuilder { kind, header, arrays, body } = builder;
        Self { kind, header, arrays, body }
    }

    fn is_floats(&self, name: &str) -> bool {
        self.arrays.get(name).and_then(|place| place.get(2)?.as_str()) == Some("f32")
    }

    /// Names of all arrays.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.arrays.keys().map(String::as_str)
    }

    /// The numbers of an array; `None` if there is no such array or it is cut off.
    pub fn floats(&self, name: &str) -> Option<Vec<f32>> {
        let bytes = self.slice(name, 4)?;
        Some(
            bytes
                .chunks_exact(4)
                .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]))
                .collect(),
        )
    }

    /// The bytes of an array.
    pub fn bytes(&self, name: &str) -> Option<&[u8]> {
        self.slice(name, 1)
    }

    fn slice(&self, name: &str, size: usize) -> Option<&[u8]> {
        let place = self.arrays.get(name)?.as_array()?;
        let number = |i: usize| usize::try_from(place.get(i)?.as_u64()?).ok();
        let offset = number(0)?;
        self.body.get(offset..offset.checked_add(number(1)?.checked_mul(size)?)?)
    }
}

/// The same message with less bytes; as it is, if it is packed already or packing gains nothing.
pub(crate) fn packed(message: &[u8]) -> Cow<'_, [u8]> {
    let pack = || {
        if message.get(PACKING) == Some(&PACKED) {
            return None;
        }
        let (prefix, content) = message.split_at_checked(PREFIX)?;
        let mut encoder = DeflateEncoder::new(prefix.to_vec(), Compression::default());
        encoder.write_all(content).ok()?;
        let mut packed = encoder.finish().ok()?;
        *packed.get_mut(PACKING)? = PACKED;
        Some(packed)
    };
    match pack().filter(|packed| packed.len() < message.len()) {
        Some(packed) => Cow::Owned(packed),
        None => Cow::Borrowed(message),
    }
}

/// The same message as it was before it was packed; as it is, if what is packed is damaged.
pub(crate) fn plain(message: Vec<u8>) -> Vec<u8> {
    if message.get(PACKING) != Some(&PACKED) {
        return message;
    }
    let Some(content) = unpacked(&message) else { return message };
    let mut plain = message[..PREFIX].to_vec();
    plain[PACKING] = 0;
    plain.extend_from_slice(&content);
    plain
}

/// Header and arrays; `None` if what is packed is damaged.
fn unpacked(message: &[u8]) -> Option<Cow<'_, [u8]>> {
    let content = message.get(PREFIX..)?;
    if message[PACKING] != PACKED {
        return Some(Cow::Borrowed(content));
    }
    let mut unpacked = Vec::new();
    DeflateDecoder::new(content).take(MAX_UNPACKED).read_to_end(&mut unpacked).ok()?;
    Some(Cow::Owned(unpacked))
}

/// Puts the entries of a table over those of another one.
pub(crate) fn lay_over(below: &mut Value, more: &Value) {
    if let (Some(below), Some(more)) = (below.as_object_mut(), more.as_object()) {
        below.extend(more.clone());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_comes_out() {
        let mut builder =
            MessageBuilder::new(MessageKind::State, &serde_json::json!({ "frame": 7 })).unwrap();
        builder.bytes("odd", &[1, 2, 3]);
        builder.floats("numbers", [0.5, -2.0]);
        let bytes = builder.finish();
        let message = Message::read(&bytes).unwrap();
        assert_eq!((message.kind, message.header["frame"].as_u64()), (MessageKind::State, Some(7)));
        assert_eq!(message.bytes("odd"), Some(&[1, 2, 3][..]));
        assert_eq!(message.floats("numbers"), Some(vec![0.5, -2.0]));
        assert_eq!(message.floats("others"), None);
        assert_eq!(bytes.len() % 4, 0);
        assert_eq!(message.clone().write(), bytes);
        assert_eq!(Message::read(&message.write()).unwrap().floats("numbers"), Some(vec![0.5, -2.0]));
    }

    #[test]
    fn an_array_is_replaced_and_the_others_stay() {
        let mut builder = MessageBuilder::new(MessageKind::Image, &serde_json::json!({ "a": 1 })).unwrap();
        builder.bytes("jpeg", &[9; 400]);
        builder.floats("numbers", [0.5, f64::NAN, -2.0]);
        builder.bytes("other", &[4, 5]);
        builder.floats("unused", [7.0]);
        let message = Message::read(&builder.finish()).unwrap();
        let replaced = Message::read(&message.with_bytes("jpeg", &[1, 2, 3], &["unused"])).unwrap();
        assert_eq!(replaced.bytes("jpeg"), Some(&[1, 2, 3][..]));
        assert_eq!(replaced.bytes("other"), Some(&[4, 5][..]));
        let numbers = replaced.floats("numbers").unwrap();
        assert!(numbers[0] == 0.5 && numbers[1].is_nan() && numbers[2] == -2.0);
        assert_eq!((replaced.floats("unused"), &replaced.header), (None, &message.header));
        let short = Message::read(&message.without(&["jpeg", "numbers"]).finish()).unwrap();
        assert_eq!((short.bytes("jpeg"), short.bytes("other")), (None, Some(&[4, 5][..])));
        let whole = short.completed_by(&message);
        assert_eq!(whole.bytes("jpeg"), message.bytes("jpeg"));
        assert_eq!(Message::read(&whole.clone().write()).unwrap(), whole);
    }

    #[test]
    fn what_is_packed_is_read_and_what_gains_nothing_stays() {
        let mut builder =
            MessageBuilder::new(MessageKind::Scene, &serde_json::json!({ "text": "a".repeat(500) })).unwrap();
        builder.floats("numbers", [0.5, -2.0]);
        let bytes = builder.finish();
        let packed = packed(&bytes).into_owned();
        assert!(packed.len() < bytes.len() / 4);
        assert_eq!(Message::read(&packed).unwrap(), Message::read(&bytes).unwrap());
        assert_eq!(super::packed(&packed).as_ref(), packed, "packed once");
        assert_eq!((plain(packed.clone()), plain(bytes.clone())), (bytes.clone(), bytes));
        for end in 0..packed.len() / 2 {
            assert!(Message::read(&packed[..end]).is_err(), "cut after {end}");
        }
        let short = [1, 0, 0, 0, 0, 0, 0, 0];
        assert_eq!(super::packed(&short).as_ref(), short);
    }

    #[test]
    fn damaged_bytes_are_refused() {
        let bytes = MessageBuilder::new(MessageKind::Scene, &serde_json::json!({})).unwrap().finish();
        for end in 0..bytes.len() {
            assert!(Message::read(&bytes[..end]).is_err(), "cut after {end}");
        }
        let mut wrong = bytes;
        wrong[0] = 9;
        assert!(Message::read(&wrong).is_err());
        assert!(MessageBuilder::new(MessageKind::Scene, &3).is_err());
    }
}
