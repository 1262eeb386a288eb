//! Parameters that cannot be used.

use thiserror::Error;
use visloc_core::settings::SettingsError;

/// Parameters that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The text is not TOML, a key does not exist, or a value is of the wrong kind or out of its range.
    #[error("{0}")]
    Settings(#[from] SettingsError),
    /// Two values do not go together.
    #[error("{key}: expected {expected}, found {found}")]
    Relation {
        /// Name of the parameter.
        key: &'static str,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// There is no thread for mapping.
    #[error("cannot start a thread for mapping: {0}")]
    Thread(String),
    /// There is no such preset.
    #[error("expected one of {known}; found '{name}'")]
    UnknownPreset {
        /// The name.
        name: String,
        /// All names.
        known: String,
    },
}
