//! What can go wrong in an experiment.

use std::{collections::BTreeSet, io, path::PathBuf};

use visloc_locate::ConfigError;
use visloc_plot::PlotError;

/// Why an experiment cannot go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// A parameter of an algorithm.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A study or picture cannot be set up.
    #[error("{reason}")]
    Setup {
        /// What stopped it.
        reason: String,
    },
    /// A run could not be done.
    #[error("cell {cell:?}, run {run}: {reason}")]
    Run {
        /// Label of the cell.
        cell: String,
        /// Number of the run.
        run: u64,
        /// What stopped it.
        reason: String,
    },
    /// A file or folder cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A folder holds something other than these runs.
    #[error("{}: {reason}", path.display())]
    Folder {
        /// The folder or its manifest.
        path: PathBuf,
        /// What was expected and found.
        reason: String,
    },
    /// A picture could not be saved.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

impl ExperimentError {
    /// Cells are told apart by their names, and lists of another folder may be of any length.
    pub(crate) fn if_twice(what: &str, names: &[String]) -> Result<(), Self> {
        let mut known = BTreeSet::new();
        match names.iter().find(|name| !known.insert(*name)) {
            Some(name) => {
                Err(Self::Setup { reason: format!("{what}: expected each name once, found {name} again") })
            }
            None => Ok(()),
        }
    }

    pub(crate) fn file(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
