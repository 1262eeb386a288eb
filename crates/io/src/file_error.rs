//! What can be wrong with a file or a folder of a dataset.

use std::{
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;
use visloc_core::geom::CameraError;

/// Why a camera file, a trajectory or a sequence cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A line does not have the expected form.
    #[error("{}: line {line}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// What was expected and what was found.
        reason: String,
    },
    /// A folder has no layout that is known, or a file lacks something.
    #[error("{}: {reason}", path.display())]
    Form {
        /// The folder or file.
        path: PathBuf,
        /// What was expected and what was found.
        reason: String,
    },
    /// Nothing says what camera took the images of a folder.
    #[error(
        "{}: expected a calibration ({looked_for}), found none; give one with --camera FILE (visloc calibrate makes it, of photos of a board or \
         of the images themselves)",
        path.display()
    )]
    NoCamera {
        /// The folder.
        path: PathBuf,
        /// Name of the file that would have said it.
        looked_for: String,
    },
    /// The calibration cannot belong to a camera.
    #[error("{}: {source}", path.display())]
    Camera {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: CameraError,
    },
}

impl FileError {
    pub(crate) fn io(path: &Path) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::Io { path: path.clone(), source }
    }

    pub(crate) fn line(path: &Path, line: usize) -> impl Fn(String) -> Self + use<> {
        let path = path.to_path_buf();
        move |reason| Self::Line { path: path.clone(), line, reason }
    }

    pub(crate) fn form(path: &Path, reason: impl Into<String>) -> Self {
        Self::Form { path: path.to_path_buf(), reason: reason.into() }
    }
}
