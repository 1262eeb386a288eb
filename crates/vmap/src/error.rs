//! What is wrong with a file.

use std::{fmt, io, path::PathBuf};

use thiserror::Error;
use visloc_slam::map::RestoreError;

/// A file that is no map that can be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum VmapError {
    /// The file cannot be read or written.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// Nobody can be localized in it, so it is neither written nor used.
    #[error("expected a map with keyframes, found none")]
    Empty,
    /// It is another kind of file.
    #[error("expected a map of SLAM (.vmap), found something else")]
    Foreign,
    /// A newer program wrote it.
    #[error("expected a map of version {known} or older, found version {found}: a newer visloc wrote it")]
    TooNew {
        /// The newest version that this program reads.
        known: u32,
        /// The version of the file.
        found: u32,
    },
    /// A section without which nothing can be used.
    #[error("the section {section} is damaged: {reason}")]
    Section {
        /// Its name.
        section: String,
        /// What is wrong.
        reason: String,
    },
    /// The numbers contradict each other.
    #[error("the map does not hold together: {0}")]
    Restore(#[from] RestoreError),
    /// Any of these, of a file with a name.
    #[error("{}: {fault}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        fault: Box<Self>,
    },
}

/// A section that is damaged, and what that costs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// Name of the section.
    pub section: String,
    /// What is wrong.
    pub reason: String,
    /// What is missing because of it.
    pub loss: &'static str,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the section {} is damaged ({}): {}", self.section, self.reason, self.loss)
    }
}
