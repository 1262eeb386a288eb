//! Definitions of messages as text.
//!
//! Source: the language of `.msg` files (wiki.ros.org/msg for ROS 1, docs.ros.org "Interfaces" for ROS 2). A recording has the
//! definition of its type and, behind lines of `=` and `MSG: package/Type`, those of all types in it.

use std::{collections::BTreeMap, fmt::Write as _};

/// Most types that a definition may have.
const MAX_TYPES: usize = 1000;
/// Most fields and constants of one type.
const MAX_FIELDS: usize = 10_000;

/// Types that need no definition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Primitive {
    /// Numbers and truth values of so many bytes.
    Number(usize),
    Text,
    /// Seconds and nanoseconds, each of 32 bits.
    Time,
    Duration,
}

impl Primitive {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "bool" | "int8" | "uint8" | "byte" | "char" => Self::Number(1),
            "int16" | "uint16" => Self::Number(2),
            "int32" | "uint32" | "float32" => Self::Number(4),
            "int64" | "uint64" | "float64" => Self::Number(8),
            "string" => Self::Text,
            "time" => Self::Time,
            "duration" => Self::Duration,
            _ => return None,
        })
    }
}

/// How many values a field has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    /// As many as a number of 32 bits before them says.
    Counted,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ValueType {
    Primitive(Primitive),
    /// Full name, `package/Type`.
    Message(String),
}

/// A field of ROS 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    /// Name of the type as ROS 2 writes it, without the count.
    ros2_type: String,
    pub value: ValueType,
    pub count: Count,
    /// As ROS 2 writes it.
    name: String,
    /// Whether ROS 2 has it; the number in the header it has not.
    pub is_kept: bool,
}

/// A message type of ROS 1.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Message {
    pub fields: Vec<Field>,
    /// `type NAME=value` as ROS 2 writes it.
    constants: Vec<String>,
}

/// All types of a definition by their full names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Definition {
    pub types: BTreeMap<String, Message>,
}

impl Definition {
    /// Takes a definition apart.
    ///
    /// # Errors
    /// What was expected and what was found.
    pub(super) fn parse(type_name: &str, text: &str) -> Result<Self, String> {
        let mut types = BTreeMap::new();
        let mut name = type_name.to_string();
        let mut message = Message::default();
        let mut is_head = false;
        for line in text.lines().map(str::trim) {
            if line.len() >= 10 && line.bytes().all(|byte| byte == b'=') {
                is_head = true;
            } else if let Some(next) = line.strip_prefix("MSG:").filter(|_| is_head) {
                is_head = false;
                types
                    .entry(std::mem::replace(&mut name, next.trim().to_string()))
                    .or_insert(std::mem::take(&mut message));
                if types.len() > MAX_TYPES {
                    return Err(format!("expected at most {MAX_TYPES} types"));
                }
            } else {
                message.take_line(&name, line)?;
            }
        }
        types.entry(name).or_insert(message);
        Ok(Self { types })
    }

    /// The definition as ROS 2 writes it (`ros2msg`), with everything in it.
    pub(super) fn ros2_text(&self, type_name: &str) -> String {
        let mut text = self.types.get(type_name).map(Message::ros2_text).unwrap_or_default();
        let others = self.types.iter().filter(|(name, _)| *name != type_name && *name != "Header");
        let others = others.map(|(name, message)| (name.as_str(), message.ros2_text()));
        let uses = |primitive| {
            let mut fields = self.types.values().flat_map(|message| &message.fields);
            fields.any(|field| field.value == ValueType::Primitive(primitive))
        };
        let time = uses(Primitive::Time)
            .then(|| ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n".to_string()));
        let duration = uses(Primitive::Duration)
            .then(|| ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n".to_string()));
        for (name, fields) in others.chain(time).chain(duration) {
            let line = "=".repeat(80);
            // Writing to a string cannot fail.
            let _ = write!(text, "{line}\nMSG: {name}\n{fields}");
        }
        text
    }
}

impl Message {
    fn take_line(&mut self, message_name: &str, line: &str) -> Result<(), String> {
        let code = line.split('#').next().unwrap_or_default().trim();
        let Some((type_text, rest)) = code.split_once(char::is_whitespace) else {
            return if code.is_empty() {
                Ok(())
            } else {
                Err(format!("expected 'TYPE NAME', found '{line}'"))
            };
        };
        if self.fields.len() + self.constants.len() >= MAX_FIELDS {
            return Err(format!("expected at most {MAX_FIELDS} fields"));
        }
        if let Some((name, value)) = rest.split_once('=') {
            // The value of a text goes on to the end of the line, whatever is in it.
            let text = line.split_once('=').map_or(value, |(_, value)| value).trim();
            self.constants.extend(constant(type_text, name.trim(), value.trim(), text));
            return Ok(());
        }
        let (base, count) = split_count(type_text)?;
        let (value, ros2_type) = value_type(message_name, base)?;
        let is_header = matches!(message_name, "std_msgs/Header" | "Header");
        let name = rest.trim();
        if !name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_') {
            return Err(format!("expected the name of a field, found '{name}'"));
        }
        let is_kept = !(is_header && name == "seq");
        let mut field = Field { ros2_type, value, count, name: snake_case(name), is_kept };
        while self.fields.iter().any(|other| other.name == field.name) {
            field.name.push_str("_x");
        }
        self.fields.push(field);
        Ok(())
    }

    fn ros2_text(&self) -> String {
        let mut text: String = self.constants.iter().map(|constant| format!("{constant}\n")).collect();
        for field in self.fields.iter().filter(|field| field.is_kept) {
            let count = match field.count {
                Count::One => String::new(),
                Count::Fixed(number) => format!("[{number}]"),
                Count::Counted => "[]".into(),
            };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}{count} {}", field.ros2_type, field.name);
        }
        text
    }
}

/// `float64[9]` is nine values of `float64`.
fn split_count(text: &str) -> Result<(&str, Count), String> {
    let Some((base, count)) = text.split_once('[') else { return Ok((text, Count::One)) };
    let count = count.strip_suffix(']').ok_or_else(|| format!("expected 'TYPE[N]', found '{text}'"))?;
    if count.is_empty() {
        return Ok((base, Count::Counted));
    }
    let number = count.parse().map_err(|_| format!("expected a number of values, found '{text}'"))?;
    Ok((base, Count::Fixed(number)))
}

/// What a type is, and its name in ROS 2. Names without a package are of the package they stand in.
fn value_type(message_name: &str, base: &str) -> Result<(ValueType, String), String> {
    if let Some(primitive) = Primitive::of(base) {
        let ros2_type = match primitive {
            Primitive::Time => "builtin_interfaces/Time",
            Primitive::Duration => "builtin_interfaces/Duration",
            _ => base,
        };
        return Ok((ValueType::Primitive(primitive), ros2_type.into()));
    }
    let is_name = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'/';
    if base.is_empty() || !base.bytes().all(is_name) {
        return Err(format!("expected a type, found '{base}'"));
    }
    let full = match message_name.split_once('/') {
        _ if base == "Header" => "std_msgs/Header".to_string(),
        _ if base.contains('/') => base.to_string(),
        Some((package, _)) => format!("{package}/{base}"),
        None => base.to_string(),
    };
    Ok((ValueType::Message(full.clone()), full))
}

/// A constant as ROS 2 writes it; `None` for those that have no place there.
fn constant(type_text: &str, name: &str, value: &str, text: &str) -> Option<String> {
    let is_name = |name: &str| {
        name.starts_with(|c: char| c.is_ascii_uppercase())
            && name.bytes().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit() || byte == b'_')
            && !name.ends_with('_')
            && !name.contains("__")
    };
    let name = name.to_ascii_uppercase();
    if !is_name(&name) {
        return None;
    }
    match Primitive::of(type_text)? {
        Primitive::Number(_) => Some(format!("{type_text} {name}={value}")),
        Primitive::Text if !text.contains(['\'', '"', '\\']) => Some(format!("string {name}='{text}'")),
        _ => None,
    }
}

/// A name as ROS 2 wants it: `frameId` becomes `frame_id`, `K` becomes `k`.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    let mut was_lower = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() && was_lower {
            snake.push('_');
        }
        was_lower = c.is_ascii_lowercase() || c.is_ascii_digit();
        if !(c == '_' && (snake.is_empty() || snake.ends_with('_'))) {
            snake.push(c.to_ascii_lowercase());
        }
    }
    let snake = snake.trim_end_matches('_');
    if snake.starts_with(|c: char| c.is_ascii_lowercase()) { snake.into() } else { format!("x{snake}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMU: &str = "# An IMU\nHeader header\nfloat64[9] covariance # row by row\nOther[] others\nint8 LEFT=-1\nstring NAME= a # b\n\
                       ================================================================================\nMSG: std_msgs/Header\n\
                       uint32 seq\ntime stamp\nstring frame_id\n\
                       ================================================================================\nMSG: my_msgs/Other\n\
                       duration D\nuint8[] frameData\n";

    #[test]
    fn the_text_of_ros_2() {
        let definition = Definition::parse("my_msgs/Imu", IMU).unwrap();
        let line = "=".repeat(80);
        let expected = format!(
            "int8 LEFT=-1\nstring NAME='a # b'\nstd_msgs/Header header\nfloat64[9] covariance\nmy_msgs/Other[] others\n{line}\n\
             MSG: my_msgs/Other\nbuiltin_interfaces/Duration d\nuint8[] frame_data\n{line}\nMSG: std_msgs/Header\n\
             builtin_interfaces/Time stamp\nstring frame_id\n{line}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
             {line}\nMSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n"
        );
        assert_eq!(definition.ros2_text("my_msgs/Imu"), expected);
    }

    #[test]
    fn what_is_no_definition_is_refused() {
        for text in ["float64", "float64[x] a", "float64[3 a", "uint8 a b", "b@d a", "uint8[-1] a"] {
            assert!(Definition::parse("a/B", text).is_err(), "{text}");
        }
        assert_eq!(Definition::parse("a/B", "").unwrap().ros2_text("a/B"), "");
    }

    #[test]
    fn names_of_fields() {
        for (ros1, ros2) in
            [("K", "k"), ("frame_id", "frame_id"), ("frameId", "frame_id"), ("_a__b_", "a_b"), ("4x", "x4x")]
        {
            assert_eq!(snake_case(ros1), ros2);
        }
    }
}
