//! A text that cannot be used.

use std::ops::Range;

use thiserror::Error;

/// A mistake in a text of parameters.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{}{reason}", line.map(|l| format!("line {l}: ")).unwrap_or_default())]
pub struct SettingsError {
    /// Line of the text, from 1, if it is known.
    pub line: Option<usize>,
    /// What was expected and found.
    pub reason: String,
}

impl SettingsError {
    pub(crate) fn at(text: &str, span: Option<Range<usize>>, reason: impl Into<String>) -> Self {
        let line = span.map(|span| {
            let before = &text.as_bytes()[..span.start.min(text.len())];
            before.iter().filter(|byte| **byte == b'\n').count() + 1
        });
        Self { line, reason: crate::settings::plain_words(&reason.into()) }
    }

    /// A mistake in values that are no text.
    pub(crate) fn of(what: &str, reason: impl std::fmt::Display) -> Self {
        Self { line: None, reason: format!("{what}: {reason}") }
    }
}
