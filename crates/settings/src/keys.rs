//! Unknown keys, and what was probably meant.

use toml::de::{DeTable, DeValue};

use crate::{SettingsError, schema::Node};

/// Refuses the first key that is unknown.
pub(crate) fn check(
    text: &str,
    table: &DeTable<'_>,
    known: Node<'_>,
    path: &str,
) -> Result<(), SettingsError> {
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        let Some(inner) = known.get(name) else {
            let reason = unknown(name, path, &known.keys().collect::<Vec<_>>());
            return Err(SettingsError::at(text, Some(key.span()), reason));
        };
        if let DeValue::Table(below) = value.get_ref()
            && inner.keys().next().is_some()
        {
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            check(text, below, inner, &path)?;
        }
    }
    Ok(())
}

fn unknown(name: &str, path: &str, known: &[&str]) -> String {
    let place = if path.is_empty() { String::new() } else { format!(" in [{path}]") };
    let help = match nearest(name, known) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("known: {}", known.join(", ")),
    };
    format!("unknown key `{name}`{place}, {help}")
}

/// The known key that needs the fewest changes, if these are few for its length.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let changes = |key: &&&str| strsim::damerau_levenshtein(name, key);
    let best = known.iter().min_by_key(changes)?;
    (changes(&best) <= name.len().max(best.len()) / 2).then_some(*best)
}
