//! A text laid over defaults.

use std::ops::Range;

use toml::{
    Spanned,
    de::{DeTable, DeValue, Deserializer},
};

use crate::settings::{Idle, Settings, SettingsError, idle, keys, schema::Schema};

/// The defaults with what a TOML text says differently; it names only what it changes, at any depth.
///
/// # Errors
/// As [`lay`], and if a value that is changed counts for nothing with the others (see [`idle`]); the error says in which line.
pub fn overlay<T: Settings>(defaults: &T, text: &str) -> Result<T, SettingsError> {
    let values = lay(defaults, text)?;
    match idle(defaults, &values)? {
        None => Ok(values),
        Some(Idle { path, reason }) => {
            Err(SettingsError::at(text, span_of(text, &path), format!("{path}: {reason}")))
        }
    }
}

/// As [`overlay`] for one of several texts, of which a later one may say that what this one changes counts.
///
/// # Errors
/// If the text is not TOML, a key is unknown, or a value has the wrong type or is out of the range that its type names
/// (`#[schemars(range(min = .., max = ..))]`); the error says in which line.
pub fn lay<T: Settings>(defaults: &T, text: &str) -> Result<T, SettingsError> {
    let refused = |error: &toml::de::Error| SettingsError::at(text, error.span(), error.message());
    let given = DeTable::parse(text).map_err(|error| refused(&error))?;
    let schema = Schema::of::<T>();
    keys::check(text, given.get_ref(), (schema.root(), schema.root()), "")?;
    let default_text =
        toml::to_string(defaults).map_err(|error| SettingsError::at("", None, error.to_string()))?;
    let mut merged = DeTable::parse(&default_text).map_err(|error| refused(&error))?;
    let span = given.span();
    lay_over(merged.get_mut(), given.into_inner());
    let merged = Spanned::new(span, merged.into_inner());
    T::deserialize(Deserializer::from(merged)).map_err(|error| refused(&error))
}

/// Checks the ranges that the types name, for values that were not read from a text.
///
/// # Errors
/// If a number is out of its range; the error names the key.
pub fn check_ranges<T: Settings>(values: &T) -> Result<(), SettingsError> {
    let values = serde_json::to_value(values)
        .map_err(|error| SettingsError { line: None, reason: error.to_string() })?;
    values.as_object().map_or(Ok(()), |values| keys::check_values(values, Schema::of::<T>().root(), ""))
}

/// Where a text sets a value.
fn span_of(text: &str, path: &str) -> Option<Range<usize>> {
    let table = DeTable::parse(text).ok()?;
    let mut table = table.get_ref();
    let mut span = None;
    for step in path.split('.') {
        let (key, value) = table.get_key_value(step)?;
        span = Some(key.span());
        match value.get_ref() {
            DeValue::Table(below) => table = below,
            _ => break,
        }
    }
    span
}

fn lay_over<'t>(base: &mut DeTable<'t>, over: DeTable<'t>) {
    for (key, value) in over {
        let inner = base.get_mut(&key).map(Spanned::get_mut);
        match (inner, value.get_ref()) {
            (Some(DeValue::Table(inner)), DeValue::Table(_)) => {
                if let DeValue::Table(given) = value.into_inner() {
                    lay_over(inner, given);
                }
            }
            _ => {
                // The key is put in anew, so that its place is that in the user's text.
                base.remove(&key);
                base.insert(key, value);
            }
        }
    }
}
