//! Files whose names the program chooses.

use std::{
    fs::{self, File},
    io::{self, ErrorKind},
    path::{Path, PathBuf},
};

/// Numbers that are tried.
const MAX_FILES: u32 = 100_000;

/// Makes an empty file `STEM-NUMBER.EXTENSION` with the first number that is free, and its folder. A file that is there already stays
/// as it is, whoever makes it at the same time.
///
/// # Errors
/// If the folder cannot be written to, or no number is free.
pub fn new_file(folder: &Path, stem: &str, extension: &str) -> io::Result<PathBuf> {
    open_new_file(folder, stem, extension).map(|(path, _)| path)
}

/// The same, open to be written.
pub(crate) fn open_new_file(folder: &Path, stem: &str, extension: &str) -> io::Result<(PathBuf, File)> {
    fs::create_dir_all(folder)?;
    for number in 1..MAX_FILES {
        let path = folder.join(format!("{stem}-{number:03}.{extension}"));
        match File::create_new(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    let reason = format!("expected fewer than {MAX_FILES} files {stem}-NUMBER.{extension}");
    Err(io::Error::new(ErrorKind::AlreadyExists, reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_numbered_and_none_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("deep/down");
        let first = new_file(&folder, "map", "ply").unwrap();
        fs::write(&first, "kept").unwrap();
        let second = new_file(&folder, "map", "ply").unwrap();
        assert_eq!([&first, &second].map(|path| path.file_name().unwrap()), ["map-001.ply", "map-002.ply"]);
        assert_eq!(new_file(&folder, "map", "tum").unwrap().file_name().unwrap(), "map-001.tum");
        fs::remove_file(&second).unwrap();
        assert_eq!(new_file(&folder, "map", "ply").unwrap(), second, "the first free number");
        assert_eq!(fs::read_to_string(first).unwrap(), "kept");
        assert!(new_file(&folder.join("map-001.ply"), "map", "ply").is_err(), "a file is no folder");
    }
}
