//! What can be wrong with a camera file.

use std::{
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;
use visloc_core::geom::CameraError;

use crate::sequence::SequenceError;

/// Why a camera file cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CameraFileError {
    /// The file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The text is not what it should be.
    #[error("{}: {reason}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// What was expected and what was found.
        reason: String,
    },
    /// No camera has these values.
    #[error("{}: {source}", path.display())]
    Camera {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: CameraError,
    },
    /// A file in one of the forms of datasets.
    #[error(transparent)]
    Dataset(#[from] SequenceError),
}

impl CameraFileError {
    pub(super) fn io(path: &Path) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::Io { path: path.clone(), source }
    }

    pub(super) fn form(path: &Path, reason: impl Into<String>) -> Self {
        Self::Form { path: path.to_path_buf(), reason: reason.into() }
    }
}
