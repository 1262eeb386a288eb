//! Reading and writing files.

use std::{io::Write, path::Path};

use visloc_core::files::{self, NewFile};
use visloc_slam::map::SessionCamera;

use crate::{MAX_FILE_BYTES, OpenedMap, VisualMap, VmapError};

/// Reads a map.
///
/// # Errors
/// As [`VisualMap::from_bytes`], or if the file cannot be read or is too long.
pub fn load(path: &Path) -> Result<OpenedMap, VmapError> {
    VisualMap::from_bytes(&files::read(path, MAX_FILE_BYTES)?)
}

/// Writes a map: beside the file of that name first, so that at any moment there is a whole one. A file that was there is kept as
/// `NAME~`.
///
/// # Errors
/// If it cannot be written; the file that was there is untouched then.
pub fn save(path: &Path, map: &VisualMap, own: &SessionCamera) -> Result<(), VmapError> {
    let mut file = NewFile::create(path)?;
    file.write_all(&map.to_bytes(own))?;
    Ok(file.finish_and_keep()?)
}
