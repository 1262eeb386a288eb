//! Unknown keys, with what was probably meant, and numbers out of their range.

use serde_json::{Map, Value};
use toml::de::{DeTable, DeValue};

use crate::settings::{SettingsError, schema::Node};

/// Refuses the first key that is unknown or whose number is out of range. `known` are the keys below a path in `all`.
pub(crate) fn check(
    text: &str,
    table: &DeTable<'_>,
    (known, all): (Node<'_>, Node<'_>),
    path: &str,
) -> Result<(), SettingsError> {
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        let Some(inner) = known.get(name) else {
            let reason = match known.no_key(name) {
                Some(reason) => format!("`{}` cannot be set: {reason}", joined(path, name)),
                None => unknown(name, path, (known, all)),
            };
            return Err(SettingsError::at(text, Some(key.span()), reason));
        };
        if let Some(reason) =
            out_of_range(text.get(value.span()).unwrap_or_default(), inner, &joined(path, name))
        {
            return Err(SettingsError::at(text, Some(value.span()), reason));
        }
        if let DeValue::Table(below) = value.get_ref()
            && inner.keys().next().is_some()
        {
            check(text, below, (inner, all), &joined(path, name))?;
        }
    }
    Ok(())
}

fn joined(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

/// What is wrong with a number as it is written; what is not a number is refused elsewhere.
fn out_of_range(written: &str, known: Node<'_>, path: &str) -> Option<String> {
    let value: f64 = written.replace('_', "").parse().ok()?;
    let range = known.range().filter(|range| !range.contains(value))?;
    Some(format!("{path}: expected {range}, found {written}"))
}

/// Refuses the first number that is out of range.
pub(crate) fn check_values(
    values: &Map<String, Value>,
    known: Node<'_>,
    path: &str,
) -> Result<(), SettingsError> {
    for (name, value) in values {
        let Some(inner) = known.get(name) else { continue };
        let path = joined(path, name);
        let reason = match value {
            Value::Object(below) => {
                check_values(below, inner, &path)?;
                None
            }
            // JSON has no word for NaN and infinity.
            Value::Null if inner.is_number() => out_of_range("NaN", inner, &path),
            other => out_of_range(&other.to_string(), inner, &path),
        };
        if let Some(reason) = reason {
            return Err(SettingsError { line: None, reason });
        }
    }
    Ok(())
}

fn unknown(name: &str, path: &str, (known, all): (Node<'_>, Node<'_>)) -> String {
    let place = if path.is_empty() { String::new() } else { format!(" in [{path}]") };
    let known: Vec<&str> = known.keys().collect();
    let same_end = paths_to(name, all, "");
    let help = match (&same_end[..], nearest_key(name, &known)) {
        ([], Some(nearest)) => format!("did you mean `{nearest}`?"),
        ([], None) => format!("known: {}", known.join(", ")),
        _ => format!("did you mean `{}`?", same_end.join("` or `")),
    };
    format!("unknown key `{name}`{place}, {help}")
}

/// Where keys of a name are, below a path.
fn paths_to(name: &str, below: Node<'_>, path: &str) -> Vec<String> {
    let deeper = below.keys().filter_map(|key| Some((key, below.get(key)?)));
    let deeper = deeper.flat_map(|(key, inner)| {
        let path = joined(path, key);
        let within = paths_to(name, inner, &path);
        (key == name).then_some(path).into_iter().chain(within)
    });
    deeper.collect()
}

/// The known key that needs the fewest changes, if these are few for its length.
pub fn nearest_key<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let changes = |key: &&&str| strsim::damerau_levenshtein(name, key);
    let best = known.iter().min_by_key(changes)?;
    (changes(&best) <= name.len().max(best.len()) / 2).then_some(*best)
}
