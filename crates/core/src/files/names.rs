//! Names of files: where they lead, those beside them, and those that only a folder can have.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Links that lead to links are followed so far, as the system does.
pub(super) const MAX_LINKS: usize = 40;

/// Where the file that had a name before is kept: `NAME~`.
pub fn kept_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push("~");
    name.into()
}

/// Where a file that grows is until it is complete: `NAME.part`.
pub fn part_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Where a path leads through links, the last of which may lead to a file that is not there yet.
pub fn target_of(path: &Path) -> PathBuf {
    let mut target = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        if let Ok(found) = fs::canonicalize(&target) {
            return found;
        }
        let Ok(next) = fs::read_link(&target) else { return target };
        target = folder_of(&target).join(next);
    }
    path.to_path_buf()
}

/// Whether a name can be that of a folder only: it ends with a separator.
pub fn is_name_of_folder(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|last| std::path::is_separator(char::from(*last)))
}

pub(super) fn refuse_folder_name(path: &Path) -> io::Result<()> {
    let message = "expected the name of a file, found one that ends as that of a folder";
    if is_name_of_folder(path) { Err(io::Error::new(io::ErrorKind::IsADirectory, message)) } else { Ok(()) }
}

pub(super) fn refuse_folder(found: &fs::Metadata) -> io::Result<()> {
    let message = "expected the name of a file, found a folder";
    if found.is_dir() { Err(io::Error::new(io::ErrorKind::IsADirectory, message)) } else { Ok(()) }
}
