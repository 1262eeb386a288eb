//! What can go wrong in the studio.

use thiserror::Error;
use visloc_core::settings::SettingsError;
use visloc_io::image_codec::ImageCodecError;
use visloc_locate::{ConfigError, lineup::LineupError, vision::AnalysisError};
use visloc_sim::ScenarioError;

use crate::{MessageError, recording::RecordingError};

/// Why something cannot be done. The message is for the person at the page.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudioError {
    /// The world cannot be built.
    #[error(transparent)]
    Scenario(Box<ScenarioError>),
    /// An algorithm cannot run so.
    #[error(transparent)]
    Lineup(Box<LineupError>),
    /// A parameter is wrong.
    #[error(transparent)]
    Config(Box<ConfigError>),
    /// An image cannot be analyzed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// A picture cannot be encoded.
    #[error(transparent)]
    Image(#[from] ImageCodecError),
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(Box<RecordingError>),
    /// A message cannot be made or read.
    #[error(transparent)]
    Message(#[from] MessageError),
    /// A command that makes no sense here.
    #[error("{what}: expected {expected}, found {found}")]
    Command {
        /// What was to be set or done.
        what: String,
        /// What is possible.
        expected: String,
        /// What was asked for.
        found: String,
    },
    /// A file or a connection.
    #[error("{origin}: {reason}")]
    Input {
        /// Which one.
        origin: String,
        /// What was expected and found.
        reason: String,
    },
}

/// Large ones are boxed, so that a result is small.
macro_rules! boxed {
    ($($variant:ident: $error:ty),*) => {
        $(impl From<$error> for StudioError {
            fn from(error: $error) -> Self {
                Self::$variant(Box::new(error))
            }
        })*
    };
}
boxed!(Scenario: ScenarioError, Lineup: LineupError, Recording: RecordingError, Config: ConfigError);

impl From<SettingsError> for StudioError {
    fn from(error: SettingsError) -> Self {
        LineupError::from(error).into()
    }
}

impl StudioError {
    /// A command that makes no sense here: what was to be done, what is possible, and what was asked for.
    pub fn command(what: impl Into<String>, expected: impl Into<String>, found: impl ToString) -> Self {
        Self::Command { what: what.into(), expected: expected.into(), found: found.to_string() }
    }

    /// A file or a connection that cannot be used, and why. A reason that names it already is told as it is.
    pub fn input(origin: impl ToString, reason: impl ToString) -> Self {
        let (origin, mut reason) = (origin.to_string(), reason.to_string());
        if let Some(alone) = reason.strip_prefix(&origin).and_then(|rest| rest.strip_prefix(": ")) {
            reason = alone.to_owned();
        }
        Self::Input { origin, reason }
    }
}
