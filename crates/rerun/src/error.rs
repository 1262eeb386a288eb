//! What can go wrong.

use std::path::PathBuf;

use thiserror::Error;
use visloc_studio::MessageError;

/// A file of the Rerun viewer that cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RerunError {
    /// This program was built without it.
    #[error(
        "{}: this visloc was built without files of the Rerun viewer; build it with `cargo build --release --features rerun`, or \
         record for the studio with a name that ends in .mcap",
        path.display()
    )]
    NotBuilt {
        /// The file that was wanted.
        path: PathBuf,
    },
    /// The disk or the folder does not take it.
    #[error("{}: cannot write the file for the Rerun viewer: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// What was to be written is no message of the studio.
    #[error(transparent)]
    Message(#[from] MessageError),
}
