//! What can be wrong with a sequence.

use std::{io, path::PathBuf};

use thiserror::Error;
use visloc_geom::CameraError;

/// Why a sequence cannot be opened, or a file of it not be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SequenceError {
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
    /// The folder has no layout that is known.
    #[error("{}: {reason}", path.display())]
    Layout {
        /// The folder.
        path: PathBuf,
        /// What was looked for.
        reason: String,
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
