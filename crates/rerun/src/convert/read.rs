//! What is read from messages. What is missing or of another type is left out: a message of another version still shows the rest.

use serde_json::{Map, Value};
use visloc_studio::Message;

/// A number of a table.
pub(super) fn number(table: &Value, key: &str) -> Option<f64> {
    table.get(key)?.as_f64()
}

/// A text of a table.
pub(super) fn text<'a>(table: &'a Value, key: &str) -> Option<&'a str> {
    table.get(key)?.as_str()
}

/// The entries of a list.
pub(super) fn list(table: Option<&Value>) -> impl Iterator<Item = &Value> {
    table.and_then(Value::as_array).into_iter().flatten()
}

/// A list of so many numbers.
pub(super) fn numbers<const N: usize>(value: Option<&Value>) -> Option<[f64; N]> {
    let values: Option<Vec<f64>> = value?.as_array()?.iter().map(Value::as_f64).collect();
    values?.try_into().ok()
}

/// Names of the algorithms, as parts of paths; each is unique.
pub(super) fn lanes(state: &Map<String, Value>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for contender in list(state.get("contenders")) {
        let name = slug(text(contender, "name").unwrap_or("algorithm"));
        let is_taken = names.contains(&name);
        names.push(if is_taken { format!("{name}-{}", names.len() + 1) } else { name });
    }
    names
}

/// A name that can be a part of a path.
pub(super) fn slug(name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let plain: String =
        name.chars().map(|c| if is_plain(c) { c.to_ascii_lowercase() } else { '-' }).collect();
    plain.trim_matches('-').replace("--", "-")
}

/// Points of an array, each so many numbers.
pub(super) fn tuples<const N: usize>(message: &Message, name: &str) -> Option<Vec<[f32; N]>> {
    let values = message.floats(name)?;
    Some(values.as_chunks::<N>().0.to_vec())
}

/// A number as the viewer wants it.
pub(super) fn single(value: f64) -> f32 {
    value as f32
}

/// Numbers as the viewer wants them.
pub(super) fn singles<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(single)
}
