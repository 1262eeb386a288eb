//! What a lineup refuses.

use thiserror::Error;
use visloc_core::settings::SettingsError;

use crate::{ConfigError, vision::AnalysisError};

/// Why algorithms cannot run so.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LineupError {
    /// An algorithm cannot be built, or a parameter is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Parameters cannot be read or written.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// An image cannot be analyzed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// A value that a parameter cannot have.
    #[error("{path} = {value}: {reason}")]
    Parameter {
        /// The parameter.
        path: String,
        /// The value.
        value: serde_json::Value,
        /// What is possible.
        reason: String,
    },
    /// A change that is impossible.
    #[error("{what}: expected {expected}, found {found}")]
    Refused {
        /// What was to be set.
        what: String,
        /// What is possible.
        expected: String,
        /// What was asked for.
        found: String,
    },
}

impl LineupError {
    pub(crate) fn refused(what: &str, expected: impl Into<String>, found: impl ToString) -> Self {
        Self::Refused { what: what.to_owned(), expected: expected.into(), found: found.to_string() }
    }
}
