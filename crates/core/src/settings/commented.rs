//! Parameters as TOML with their meaning.

use std::fmt::Write as _;

use crate::settings::{
    Settings, SettingsError,
    schema::{Node, Schema},
};

/// Widest line of a comment.
const WIDTH: usize = 100;

/// Values as TOML, with the meaning, the condition and the range of every key above it as a comment. Keys without a value are comments, too.
///
/// # Errors
/// If the values cannot be written as TOML.
pub fn commented_toml<T: Settings>(values: &T) -> Result<String, SettingsError> {
    let plain = toml::to_string(values).map_err(|error| SettingsError::at("", None, error.to_string()))?;
    let schema = Schema::of::<T>();
    let mut out = String::new();
    comment(&mut out, schema.root().meaning());
    let table: toml::Table =
        toml::from_str(&plain).map_err(|error| SettingsError::at(&plain, error.span(), error.message()))?;
    write_table(&mut out, &table, schema.root(), "");
    Ok(out)
}

/// Values first, then tables, each in the order of the schema's keys.
fn write_table(out: &mut String, table: &toml::Table, node: Node<'_>, path: &str) {
    for key in node.keys() {
        let Some(inner) = node.get(key) else { continue };
        match table.get(key) {
            Some(toml::Value::Table(_)) => {}
            value => write_value(out, key, value, inner),
        }
    }
    for key in node.keys() {
        if let (Some(inner), Some(toml::Value::Table(below))) = (node.get(key), table.get(key)) {
            let path = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
            out.push('\n');
            comment(out, inner.meaning());
            let _ = writeln!(out, "[{path}]");
            write_table(out, below, inner, &path);
        }
    }
}

fn write_value(out: &mut String, key: &str, value: Option<&toml::Value>, node: Node<'_>) {
    if !out.is_empty() && !out.ends_with("]\n") {
        out.push('\n');
    }
    let range = node.range().map(|range| format!("Range: {range}."));
    let only_if = node.only_if().map(|condition| format!("Counts only with {condition}."));
    let meaning = [node.meaning(), only_if, range].into_iter().flatten().collect::<Vec<_>>().join(" ");
    comment(out, Some(meaning).filter(|meaning| !meaning.is_empty()));
    for (choice, meaning) in node.choices() {
        let meaning = meaning.map(|text| format!(": {text}")).unwrap_or_default();
        comment(out, Some(format!("- \"{choice}\"{meaning}")));
    }
    match value {
        Some(value) => {
            let _ = writeln!(out, "{key} = {value}");
        }
        None => {
            let _ = writeln!(out, "# {key} =");
        }
    }
}

fn comment(out: &mut String, text: Option<String>) {
    let Some(text) = text else { return };
    let mut line = String::from("#");
    for word in text.split(' ') {
        if line.len() + 1 + word.len() > WIDTH {
            out.push_str(&line);
            out.push('\n');
            line = String::from("#");
        }
        line.push(' ');
        line.push_str(word);
    }
    out.push_str(&line);
    out.push('\n');
}
