//! Errors of configurations, and the check that all of them share.

use thiserror::Error;
use visloc_core::settings::SettingsError;

/// A configuration that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// A value out of its range.
    #[error("{key}: expected {expected}, found {found}")]
    Value {
        /// The parameter with the part it belongs to.
        key: String,
        /// What is allowed.
        expected: &'static str,
        /// What was given.
        found: String,
    },
    /// Not TOML, or a key is unknown or has the wrong type.
    #[error("configuration of {name}{}: {reason}", line.map(|l| format!(", line {l}")).unwrap_or_default())]
    Syntax {
        /// File or algorithm.
        name: String,
        /// Line of the text, from 1.
        line: Option<usize>,
        /// What was expected and found.
        reason: String,
    },
    /// A value that its type does not allow.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A limit of the color table that would make no difference.
    #[error("{key} makes no difference while the color of the carpet is learned: add source = \"table\"")]
    NoTable {
        /// The parameter.
        key: &'static str,
    },
    /// There is no such algorithm.
    #[error("unknown algorithm {name:?}; known: {known}")]
    UnknownAlgorithm {
        /// What was asked for.
        name: String,
        /// All names.
        known: String,
    },
}

impl ConfigError {
    /// A mistake in the text of a file or an algorithm's parameters.
    pub fn from_settings(name: &str, error: SettingsError) -> Self {
        Self::Syntax { name: name.to_owned(), line: error.line, reason: error.reason }
    }

    /// The same for a text that nobody sees, in which a line says nothing.
    #[must_use]
    pub fn without_line(self) -> Self {
        match self {
            Self::Syntax { name, reason, .. } => Self::Syntax { name, line: None, reason },
            other => other,
        }
    }
}

/// Checks one value of a configuration.
///
/// # Errors
/// [`ConfigError::Value`] if `holds` is false.
pub fn require(
    holds: bool,
    key: &str,
    expected: &'static str,
    found: impl std::fmt::Display,
) -> Result<(), ConfigError> {
    if holds {
        return Ok(());
    }
    Err(ConfigError::Value { key: key.to_owned(), expected, found: found.to_string() })
}
