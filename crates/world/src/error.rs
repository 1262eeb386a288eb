//! What can be wrong with a map.

use std::io::ErrorKind;

use thiserror::Error;

use crate::built_in::BUILT_IN_MAPS;

/// What to do about lengths that make no sense.
pub(crate) const WHICH_UNIT: &str =
    "is the unit right? Maps are in meters, and a drawing says how many meters its unit is (docs/own-map.md)";

/// A map that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MapError {
    /// The file cannot be read, and it is not the name of a built-in map either.
    #[error("map {name}: {}", unreadable(name, source))]
    Unreadable {
        /// What the user wrote.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not TOML, or a key is missing, unknown or of the wrong type.
    #[error("map {name}{}: {reason}", line.map(|l| format!(", line {l}")).unwrap_or_default())]
    Syntax {
        /// File or name.
        name: String,
        /// Line of the text, from 1.
        line: Option<usize>,
        /// What was expected and found.
        reason: String,
    },
    /// A value that no world can have.
    #[error("map {name}: {key}: expected {expected}, found {found}")]
    Value {
        /// File or name.
        name: String,
        /// The key.
        key: String,
        /// What is allowed.
        expected: &'static str,
        /// What the file says.
        found: String,
    },
}

fn unreadable(name: &str, source: &std::io::Error) -> String {
    // Who names the league alone means one of its fields.
    let mut meant = BUILT_IN_MAPS.iter().map(|(known, _)| *known).filter(|known| known.starts_with(name));
    let did_you_mean = meant
        .next()
        .filter(|_| !name.is_empty())
        .map_or_else(String::new, |known| format!("; did you mean '{known}'?"));
    match source.kind() {
        ErrorKind::NotFound => {
            format!("{source}{did_you_mean}; expected a file or one of: {}", built_in_names())
        }
        _ => source.to_string(),
    }
}

fn built_in_names() -> String {
    BUILT_IN_MAPS.map(|(name, _)| name).join(", ")
}

/// What to do about a map that lacks most of what one has.
pub(crate) const HOW_TO_BEGIN: &str = "'visloc map show robocup-spl-2010 --out FILE.toml' writes a whole field to begin with, 'map show office' a building";

pub(crate) fn syntax_error(name: &str, text: &str, error: &toml::de::Error) -> MapError {
    let line = error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1);
    MapError::Syntax { name: name.to_owned(), line, reason: error.message().to_owned() }
}
