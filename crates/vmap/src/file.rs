//! Reading and writing files.

use std::path::Path;

use visloc_core::files::{self, NewFile};
use visloc_slam::map::{Restoring, SessionCamera};

use crate::{MAX_FILE_BYTES, OpenedMap, VisualMap, VmapError};

/// Reads a map.
///
/// # Errors
/// As [`VisualMap::from_bytes`], or if the file cannot be read or is too long, or has no keyframes; with the name of the file.
pub fn load(path: &Path) -> Result<OpenedMap, VmapError> {
    load_as(path, Restoring::from)
}

/// Reads a map to find cameras in it: it takes less memory, as each look of a landmark is kept once. It should not be gone on in or written.
///
/// # Errors
/// As [`load`].
pub fn load_fixed(path: &Path) -> Result<OpenedMap, VmapError> {
    load_as(path, Restoring::of_fixed)
}

fn load_as(path: &Path, make: fn(Restoring) -> Restoring) -> Result<OpenedMap, VmapError> {
    let load = || {
        let file = files::open(path)?;
        files::check_length(&file, MAX_FILE_BYTES)?;
        let opened = VisualMap::read(file, make)?;
        has_keyframes(&opened.map).then_some(opened).ok_or(VmapError::Empty)
    };
    load().map_err(of_file(path))
}

fn of_file(path: &Path) -> impl Fn(VmapError) -> VmapError {
    |fault| VmapError::File { path: path.to_path_buf(), fault: Box::new(fault) }
}

fn has_keyframes(map: &VisualMap) -> bool {
    map.map.all_keyframes().next().is_some()
}

/// Writes a map: beside the file of that name first, so that at any moment there is a whole one. A file that was there is kept as
/// `NAME~`.
///
/// # Errors
/// If it has no keyframes or cannot be written, with the name of the file; one that was there is untouched then.
pub fn save(path: &Path, map: &VisualMap, own: &SessionCamera) -> Result<(), VmapError> {
    let save = || {
        if !has_keyframes(map) {
            return Err(VmapError::Empty);
        }
        let mut file = NewFile::create(path)?;
        map.write(own, &mut file)?;
        Ok(file.finish()?)
    };
    save().map_err(of_file(path))
}
