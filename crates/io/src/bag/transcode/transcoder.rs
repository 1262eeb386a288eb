//! From the bytes of ROS 1 to those of ROS 2.

use std::collections::BTreeMap;

use super::definition::{Count, Definition, Field, Message, Primitive, ValueType};

/// Deepest nesting of types.
const MAX_DEPTH: usize = 64;
/// Values that take no bytes in ROS 1 may be no more than this.
const MAX_EMPTY_VALUES: usize = 1 << 20;
/// Plain CDR, little endian.
const CDR_HEADER: [u8; 4] = [0, 1, 0, 0];

/// Turns messages of one type of ROS 1 into those of ROS 2, by the definition that a recording of ROS 1 has of them.
///
/// ```
/// use visloc_io::bag::Transcoder;
///
/// let transcoder = Transcoder::new("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id").unwrap();
/// assert_eq!(transcoder.type_name(), "std_msgs/msg/Header");
/// let ros1 = [9, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0, b'a'];
/// let ros2 = [0, 1, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0, b'a', 0];
/// assert_eq!(transcoder.to_cdr(&ros1).unwrap(), ros2);
/// ```
#[derive(Debug, Clone)]
pub struct Transcoder {
    type_name: String,
    definition: String,
    /// All types; fields name them by their places. The first is the message itself.
    structs: Vec<Vec<Step>>,
}

/// A field that is to be copied.
#[derive(Debug, Clone, Copy)]
struct Step {
    value: Value,
    count: Count,
    is_kept: bool,
}

#[derive(Debug, Clone, Copy)]
enum Value {
    Number(usize),
    Text,
    /// Two numbers of 32 bits.
    Time,
    Struct(usize),
}

impl Transcoder {
    /// For a type such as `sensor_msgs/Image` with the definition of it and of all types in it.
    ///
    /// # Errors
    /// If the definition is none, lacks a type, or types contain themselves.
    pub fn new(type_name: &str, definition: &str) -> Result<Self, String> {
        let (package, name) = type_name
            .split_once('/')
            .filter(|(package, name)| !package.is_empty() && !name.is_empty() && !name.contains('/'))
            .ok_or_else(|| format!("expected a type 'package/Name', found '{type_name}'"))?;
        let parsed = Definition::parse(type_name, definition)?;
        let mut builder = Builder { definition: &parsed, structs: Vec::new(), known: BTreeMap::new() };
        builder.compile(type_name, 0)?;
        let structs = builder.structs;
        Ok(Self {
            type_name: format!("{package}/msg/{name}"),
            definition: parsed.ros2_text(type_name),
            structs,
        })
    }

    /// The type as ROS 2 names it, such as `sensor_msgs/msg/Image`.
    pub fn type_name(&self) -> &str {
        &self.type_name
    }

    /// The definition as ROS 2 writes it (`ros2msg`), with everything in it.
    pub fn definition(&self) -> String {
        self.definition.clone()
    }

    /// A message with its four bytes of encapsulation.
    ///
    /// # Errors
    /// If the bytes are too few or too many for the definition.
    pub fn to_cdr(&self, ros1: &[u8]) -> Result<Vec<u8>, String> {
        let mut copy = Copy {
            structs: &self.structs,
            input: ros1,
            output: Vec::with_capacity(CDR_HEADER.len() + ros1.len() + ros1.len() / 8),
            num_values_left: ros1.len() + MAX_EMPTY_VALUES,
        };
        copy.output.extend(CDR_HEADER);
        copy.copy_struct(0, true)?;
        if copy.input.is_empty() {
            return Ok(copy.output);
        }
        Err(format!("expected the end of the message, found {} bytes more", copy.input.len()))
    }
}

/// Replaces names of types by places.
struct Builder<'a> {
    definition: &'a Definition,
    structs: Vec<Vec<Step>>,
    /// Places of types; `None` while a type is looked into.
    known: BTreeMap<&'a str, Option<usize>>,
}

impl<'a> Builder<'a> {
    fn compile(&mut self, type_name: &str, depth: usize) -> Result<usize, String> {
        let types: &'a BTreeMap<String, Message> = &self.definition.types;
        // Old definitions name the header without its package.
        let found = types.get_key_value(type_name);
        let found = found.or_else(|| {
            let headers = ["Header", "roslib/Header"].into_iter();
            headers.filter_map(|name| types.get_key_value(name)).find(|_| type_name == "std_msgs/Header")
        });
        let (name, message) = found.ok_or_else(|| format!("there is no definition of '{type_name}'"))?;
        match self.known.get(name.as_str()) {
            Some(Some(place)) => return Ok(*place),
            Some(None) => return Err(format!("'{type_name}' contains itself")),
            None if depth > MAX_DEPTH => {
                return Err(format!("types are nested deeper than {MAX_DEPTH} times"));
            }
            None => {}
        }
        self.known.insert(name, None);
        let place = self.structs.len();
        self.structs.push(Vec::new());
        let steps: Result<Vec<Step>, String> =
            message.fields.iter().map(|field| self.step(field, depth)).collect();
        self.structs[place] = steps?;
        self.known.insert(name, Some(place));
        Ok(place)
    }

    fn step(&mut self, field: &Field, depth: usize) -> Result<Step, String> {
        let value = match &field.value {
            ValueType::Primitive(Primitive::Number(num_bytes)) => Value::Number(*num_bytes),
            ValueType::Primitive(Primitive::Text) => Value::Text,
            ValueType::Primitive(Primitive::Time | Primitive::Duration) => Value::Time,
            ValueType::Message(name) => Value::Struct(self.compile(name, depth + 1)?),
        };
        Ok(Step { value, count: field.count, is_kept: field.is_kept })
    }
}

/// A message on its way.
struct Copy<'a> {
    structs: &'a [Vec<Step>],
    input: &'a [u8],
    output: Vec<u8>,
    num_values_left: usize,
}

impl<'a> Copy<'a> {
    fn copy_struct(&mut self, place: usize, is_kept: bool) -> Result<(), String> {
        let structs = self.structs;
        if structs[place].is_empty() {
            self.spend(1)?;
            // ROS 2 gives a message without fields one byte.
            self.put(1, &[0], is_kept);
        }
        structs[place].iter().try_for_each(|step| self.copy_field(*step, is_kept && step.is_kept))
    }

    fn copy_field(&mut self, step: Step, is_kept: bool) -> Result<(), String> {
        let number = match step.count {
            Count::One => 1,
            Count::Fixed(number) => number,
            Count::Counted => {
                let bytes = self.take(4)?;
                self.put(4, bytes, is_kept);
                number_of(bytes)
            }
        };
        match step.value {
            Value::Number(num_bytes) => self.copy_numbers(number, num_bytes, is_kept),
            Value::Time => self.copy_numbers(number.checked_mul(2).ok_or_else(too_many)?, 4, is_kept),
            Value::Text => (0..number).try_for_each(|_| self.copy_text(is_kept)),
            Value::Struct(place) => (0..number).try_for_each(|_| {
                self.spend(1)?;
                self.copy_struct(place, is_kept)
            }),
        }
    }

    fn copy_numbers(&mut self, number: usize, num_bytes: usize, is_kept: bool) -> Result<(), String> {
        let bytes = self.take(number.checked_mul(num_bytes).ok_or_else(too_many)?)?;
        // An array without values is not moved to the place of its first.
        if !bytes.is_empty() {
            self.put(num_bytes, bytes, is_kept);
        }
        Ok(())
    }

    fn copy_text(&mut self, is_kept: bool) -> Result<(), String> {
        let num_bytes = number_of(self.take(4)?);
        let text = self.take(num_bytes)?;
        // ROS 2 ends texts with a zero, which counts.
        let counted = u32::try_from(num_bytes + 1).map_err(|_| too_many())?;
        self.put(4, &counted.to_le_bytes(), is_kept);
        self.put(1, text, is_kept);
        self.put(1, &[0], is_kept);
        Ok(())
    }

    fn take(&mut self, num_bytes: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.input.split_at_checked(num_bytes).ok_or_else(|| {
            format!("expected {num_bytes} more bytes of the message, found {}", self.input.len())
        })?;
        self.input = rest;
        Ok(taken)
    }

    /// Appends bytes at a multiple of a size, counted from behind the encapsulation.
    fn put(&mut self, size: usize, bytes: &[u8], is_kept: bool) {
        if is_kept {
            let body_bytes = self.output.len() - CDR_HEADER.len();
            self.output.resize(CDR_HEADER.len() + body_bytes.next_multiple_of(size), 0);
            self.output.extend_from_slice(bytes);
        }
    }

    /// Counts values that need not have bytes, so that a few bytes cannot ask for endless ones.
    fn spend(&mut self, number: usize) -> Result<(), String> {
        self.num_values_left = self.num_values_left.checked_sub(number).ok_or_else(too_many)?;
        Ok(())
    }
}

fn number_of(bytes: &[u8]) -> usize {
    bytes.try_into().map_or(0, |bytes| u32::from_le_bytes(bytes) as usize)
}

fn too_many() -> String {
    "it asks for more values than its bytes can have".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alignment_counts_from_behind_the_first_four_bytes() {
        let transcoder =
            Transcoder::new("a/B", "uint8 x\nfloat64[] y\nbool z\nEmpty e\n==========\nMSG: a/Empty\n")
                .unwrap();
        let mut ros1 = vec![1, 1, 0, 0, 0];
        ros1.extend(2.5_f64.to_le_bytes());
        ros1.push(1);
        let mut ros2 = vec![0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];
        ros2.extend(2.5_f64.to_le_bytes());
        ros2.extend([1, 0]);
        assert_eq!(transcoder.to_cdr(&ros1).unwrap(), ros2);
        for length in 0..ros1.len() {
            assert!(transcoder.to_cdr(&ros1[..length]).unwrap_err().contains("expected"));
        }
        ros1.push(0);
        assert!(transcoder.to_cdr(&ros1).unwrap_err().contains("1 bytes more"));
    }

    #[test]
    fn definitions_that_cannot_be_used_are_refused() {
        let refused = |text: &str| Transcoder::new("a/B", text).unwrap_err();
        assert!(refused("C c").contains("no definition of 'a/C'"));
        assert!(refused("B b").contains("contains itself"));
        let link = |i: usize| format!("==========\nMSG: a/T{i}\nT{} t\n", i + 1);
        let chain: String = (0..100).map(link).collect();
        assert!(
            refused(&format!("T0 t\n{chain}==========\nMSG: a/T100\nuint8 x")).contains("deeper than 64")
        );
        assert!(Transcoder::new("B", "").is_err());
    }

    #[test]
    fn few_bytes_cannot_ask_for_many() {
        let bomb = "C[1000000000] c\n==========\nMSG: a/C\nD[1000000000] d\n==========\nMSG: a/D\n";
        assert!(Transcoder::new("a/B", bomb).unwrap().to_cdr(&[]).unwrap_err().contains("more values"));
        let texts = Transcoder::new("a/B", "string[] s").unwrap();
        assert!(texts.to_cdr(&[255, 255, 255, 255]).unwrap_err().contains("expected 4 more bytes"));
    }
}
