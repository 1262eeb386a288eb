//! The pairs of a DXF file: a group code and a value, as text or binary.
//!
//! Source: AutoCAD DXF reference, "Group codes in numerical order" and "Binary DXF files".

use std::borrow::Cow;

/// A group code with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pair<'a> {
    pub code: i32,
    pub value: Value<'a>,
    /// Line of the code, from 1; `None` in a binary file.
    pub line: Option<usize>,
}

/// What follows a group code.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value<'a> {
    Text(Cow<'a, str>),
    Number(f64),
}

impl Pair<'_> {
    /// The value as text; empty for a number of a binary file.
    pub fn text(&self) -> &str {
        if let Value::Text(text) = &self.value { text } else { "" }
    }

    /// The value as a number. The error says what it is instead.
    pub fn number(&self) -> Result<f64, String> {
        match &self.value {
            Value::Number(number) => Ok(*number),
            Value::Text(text) => text.parse().map_err(|_| format!("expected a number, found {text:?}")),
        }
    }
}

/// What a binary file begins with.
const BINARY: &[u8] = b"AutoCAD Binary DXF\r\n\x1a\0";

/// A place in the file and what is wrong there.
pub(super) type Failure = (Option<usize>, String);

/// All pairs of a file.
pub(super) fn pairs(bytes: &[u8]) -> Result<Vec<Pair<'_>>, Failure> {
    match bytes.strip_prefix(BINARY) {
        Some(rest) => binary(rest),
        None => text(bytes),
    }
}

fn text(bytes: &[u8]) -> Result<Vec<Pair<'_>>, Failure> {
    let mut pairs = Vec::new();
    let mut lines = bytes.split(|byte| *byte == b'\n').enumerate();
    while let (Some((number, code)), Some((_, value))) = (lines.next(), lines.next()) {
        let code = decoded(code);
        let parsed = code.parse().map_err(|_| {
            let found: String = code.chars().take(40).collect();
            (Some(number + 1), format!("expected a group code, found {found:?}; is it a DXF file?"))
        })?;
        let value = decoded(value);
        let is_end = parsed == 0 && value == "EOF";
        pairs.push(Pair { code: parsed, value: Value::Text(value), line: Some(number + 1) });
        if is_end {
            break;
        }
    }
    Ok(pairs)
}

/// UTF-8, or else the western code page of older drawings.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text.trim()),
        Err(_) => {
            Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect::<String>().trim().to_owned())
        }
    }
}

fn binary(bytes: &[u8]) -> Result<Vec<Pair<'_>>, Failure> {
    // Since release 13 codes have two bytes. The first pair is always (0, "SECTION").
    let is_short = bytes.first_chunk() == Some(&[0, 0]);
    let mut rest = bytes;
    let mut pairs = Vec::new();
    let cut = |pairs: &Vec<Pair<'_>>| {
        (None, format!("expected a whole file, found its end after {} pairs", pairs.len()))
    };
    while !rest.is_empty() {
        let code = if is_short || rest[0] == 255 {
            if !is_short {
                rest = &rest[1..];
            }
            take(&mut rest).map(i16::from_le_bytes).map(i32::from)
        } else {
            take(&mut rest).map(|[code]: [u8; 1]| i32::from(code))
        };
        let code = code.ok_or_else(|| cut(&pairs))?;
        let value = binary_value(code, &mut rest).ok_or_else(|| cut(&pairs))?;
        pairs.push(Pair { code, value, line: None });
    }
    Ok(pairs)
}

/// The value that belongs to a code; `None` if the file ends before.
fn binary_value<'a>(code: i32, rest: &mut &'a [u8]) -> Option<Value<'a>> {
    let number = match code {
        10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => f64::from_le_bytes(take(rest)?),
        60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => {
            f64::from(i16::from_le_bytes(take(rest)?))
        }
        90..=99 | 420..=429 | 440..=459 | 1071 => f64::from(i32::from_le_bytes(take(rest)?)),
        160..=169 => i64::from_le_bytes(take(rest)?) as f64,
        290..=299 => f64::from(take::<1>(rest)?[0]),
        310..=319 | 1004 => {
            let [length] = take(rest)?;
            *rest = rest.get(usize::from(length)..)?;
            return Some(Value::Text(Cow::Borrowed("")));
        }
        _ => {
            let end = rest.iter().position(|byte| *byte == 0)?;
            let text = decoded(&rest[..end]);
            *rest = &rest[end + 1..];
            return Some(Value::Text(text));
        }
    };
    Some(Value::Number(number))
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(*first)
}
