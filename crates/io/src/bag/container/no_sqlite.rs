//! Stands in for SQLite where it was left out of the program.

use std::path::Path;

use super::{BagMessage, DamagedBag, Wanted};
use crate::bag::{BagError, TopicInfo};

/// Cannot be made.
pub(super) enum SqliteFile {}

impl SqliteFile {
    pub(super) fn open(path: &Path, _: Wanted) -> Result<Self, BagError> {
        Err(absent(path))
    }

    pub(super) fn next_message(&mut self) -> Option<Result<BagMessage, DamagedBag>> {
        match *self {}
    }
}

/// The topics of a file.
pub(super) fn topics(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    Err(absent(path))
}

fn absent(path: &Path) -> BagError {
    BagError::Unreadable {
        path: path.to_path_buf(),
        expected: "a recording of another kind",
        reason: "it is SQLite (.db3), which this visloc was built without; build with --features sqlite"
            .to_owned(),
    }
}
