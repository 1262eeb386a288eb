//! Stands for the writer in a program that is built without it.

use std::path::Path;

use visloc_studio::Update;

use crate::RerunError;

/// A file that nobody can create: this program is built without the feature `rerun`.
#[derive(Debug)]
pub enum RerunFile {}

impl RerunFile {
    /// Refuses.
    ///
    /// # Errors
    /// Always [`RerunError::NotBuilt`], which says what to build.
    pub fn create(path: &Path) -> Result<Self, RerunError> {
        Err(RerunError::NotBuilt { path: path.to_path_buf() })
    }

    /// Appends an update of a moment, seconds since the first frame.
    ///
    /// # Errors
    /// Never called.
    pub fn add(&mut self, _update: &Update, _secs: f64) -> Result<(), RerunError> {
        match *self {}
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Never called.
    pub fn finish(self) -> Result<(), RerunError> {
        match self {}
    }
}
