//! Files of the user: read with a bound, written so that an earlier file is never half lost.
//!
//! All files that visloc reads whole come through [`read`] and [`read_text`], all that it writes whole through
//! [`write()`] and [`NewFile`]. So no command can be hung up by a device that never ends, and none leaves a half
//! written file behind under its final name.

#[cfg(feature = "files")]
mod names;
#[cfg(feature = "files")]
mod room;
#[cfg(feature = "files")]
mod write;

use std::{
    fs::{self, File},
    io::{self, Read},
    path::Path,
};

#[cfg(feature = "files")]
pub use names::{is_name_of_folder, kept_path, part_path, target_of};
#[cfg(feature = "files")]
pub use room::GrowingFile;
#[cfg(feature = "files")]
pub use write::{NewFile, create_alone, replace, try_file, try_folder, write};

/// Most bytes of a file with text that people write or list: a map, a calibration, a table of poses.
pub const MAX_TEXT_BYTES: u64 = 1 << 28;

/// Opens a file for reading. Only regular files: a device or a pipe may never end, and nobody could tell.
///
/// # Errors
/// What the system says, or that it is a folder, a device, a pipe or a socket.
pub fn open(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_file() {
        return File::open(path);
    }
    let found = if kind.is_dir() { "a folder" } else { "a device, pipe or socket, which may never end" };
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("expected a file, found {found}")))
}

/// Reads a whole file of at most so many bytes.
///
/// # Errors
/// What the system says, that it is no regular file, or that it is longer.
pub fn read(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let num_bytes = check_length(&file, max_bytes)?;
    let mut bytes = Vec::with_capacity(usize::try_from(num_bytes).unwrap_or(0));
    // A file may grow while it is read, and those of the system (/proc) say that they are empty.
    file.take(max_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes { Err(too_long(max_bytes)) } else { Ok(bytes) }
}

/// The length of a file of at most so many bytes.
///
/// # Errors
/// What the system says, or that it is longer.
pub fn check_length(file: &File, max_bytes: u64) -> io::Result<u64> {
    let num_bytes = file.metadata()?.len();
    if num_bytes > max_bytes { Err(too_long(max_bytes)) } else { Ok(num_bytes) }
}

/// Reads a whole file of text, UTF-8 of at most [`MAX_TEXT_BYTES`]. The mark that editors of Windows put in front is left out.
///
/// # Errors
/// As [`read`], or that it is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut bytes = read(path, MAX_TEXT_BYTES)?;
    bytes.drain(..bytes.len() - without_mark(&bytes).len());
    String::from_utf8(bytes).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "expected text in UTF-8"))
}

/// The bytes of a text without the mark (byte order mark) that editors of Windows put in front.
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Whether anything has this name, be it a file or not. Who wants a file if there is one asks this, not whether it is a file: then a
/// folder, a device or a broken link of that name is refused by [`open`] and not silently passed over.
pub fn is_there(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

fn too_long(max_bytes: u64) -> io::Error {
    let message = format!("expected at most {} MiB", max_bytes >> 20);
    io::Error::new(io::ErrorKind::FileTooLarge, message)
}

#[cfg(feature = "files")]
#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_appears_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/poses.txt");
        write(&path, "old").unwrap();
        let mut file = NewFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        file.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        drop(file);
        assert_eq!(names(path.parent().unwrap()), ["poses.txt"], "what is given up is removed");
        write(&path, "new").unwrap();
        assert_eq!(read_text(&path).unwrap(), "new");
    }

    #[test]
    fn what_is_replaced_is_kept_unless_it_is_empty_or_comes_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.toml");
        let kept = || read_text(&kept_path(&path)).ok();
        for (text, expected) in [("", None), ("a", None), ("b", Some("a")), ("b", Some("a")), ("", Some("b"))]
        {
            write(&path, text).unwrap();
            assert_eq!((&*read_text(&path).unwrap(), kept().as_deref()), (text, expected));
        }
        replace(&path, "picture").unwrap();
        replace(&path, "other picture").unwrap();
        assert_eq!(kept().unwrap(), "b");
        write(&part_path(&path), "somebody's own").unwrap();
        NewFile::create_growing(&path).unwrap().finish().unwrap();
        assert_eq!(read_text(&kept_path(&part_path(&path))).unwrap(), "somebody's own");
        assert_eq!((read_text(&path).unwrap(), kept().unwrap()), (String::new(), "other picture".into()));
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_needs_a_reader() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let error = write(&path, "x").unwrap_err().to_string();
        assert!(error.contains("nobody reads this pipe"), "{error}");
        let reader = std::thread::spawn({
            let path = path.clone();
            move || fs::read_to_string(path).unwrap()
        });
        write(&path, "x").unwrap();
        assert_eq!(reader.join().unwrap(), "x");
    }

    #[test]
    fn a_file_that_grows_can_be_looked_at_and_outlives_the_program() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        write(&path, "old").unwrap();
        for _ in 0..2 {
            let mut file = NewFile::create_growing(&path).unwrap();
            file.write_all(b"line").unwrap();
            file.flush().unwrap();
            drop(file);
            assert_eq!(read_text(&part_path(&path)).unwrap(), "line", "and is kept the next time");
            assert_eq!(read_text(&path).unwrap(), "old");
        }
        let mut file = NewFile::create_growing(&path).unwrap();
        file.write_all(b"all lines").unwrap();
        file.finish().unwrap();
        assert_eq!(read_text(&path).unwrap(), "all lines");
        let mut names = names(folder.path());
        names.sort();
        assert_eq!(names, ["table.csv", "table.csv.part~", "table.csv~"]);
    }

    #[test]
    fn a_file_that_is_being_written_is_not_taken_by_another() {
        let folder = tempfile::tempdir().unwrap();
        let (table, bag) = (folder.path().join("table.csv"), folder.path().join("run.mcap"));
        let mut first = NewFile::create_growing(&table).unwrap();
        let in_place = create_alone(&bag).unwrap();
        for refused in [NewFile::create_growing(&table).map(drop), create_alone(&bag).map(drop)] {
            assert_eq!(refused.unwrap_err().to_string(), "another program is writing it");
        }
        first.write_all(b"whole").unwrap();
        first.finish().unwrap();
        assert_eq!(read_text(&table).unwrap(), "whole");
        drop(in_place);
        write(&bag, "old").unwrap();
        drop(create_alone(&bag).unwrap());
        assert_eq!(read_text(&bag).unwrap(), "", "an earlier file is emptied");
    }

    #[test]
    fn trying_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        write(&path("file"), "kept").unwrap();
        try_file(&path("a/b/new")).unwrap();
        try_file(&path("file")).unwrap();
        try_folder(&path("c/d")).unwrap();
        fs::create_dir(path("file~")).unwrap();
        assert!(try_file(&path("file")).unwrap_err().to_string().contains("found a folder of that name"));
        fs::remove_dir(path("file~")).unwrap();
        assert!(try_file(folder.path()).unwrap_err().to_string().contains("found a folder"));
        assert!(try_file(&path("new/")).unwrap_err().to_string().contains("ends as that of a folder"));
        assert!(try_file(&path(&"a".repeat(251))).is_err(), "there is no room for .part");
        assert!(try_folder(&path("file")).unwrap_err().to_string().contains("expected a folder"));
        assert!(try_folder(&path("file/below")).is_err() && try_file(&path("file/below")).is_err());
        assert_eq!(
            (names(folder.path()), read_text(&path("file")).unwrap()),
            (vec!["file".into()], "kept".into())
        );
        #[cfg(target_os = "linux")]
        assert!(try_file(Path::new("/proc/new")).is_err() && try_file(Path::new("/dev/full")).is_ok());
    }

    #[test]
    fn long_files_folders_and_devices_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("long");
        write(&path, [b'x'; 11]).unwrap();
        assert_eq!(read(&path, 11).unwrap().len(), 11);
        assert!(read(&path, 10).unwrap_err().to_string().contains("at most"));
        assert!(read(folder.path(), 10).unwrap_err().to_string().contains("found a folder"));
        assert!(write(folder.path(), "").unwrap_err().to_string().contains("found a folder"));
        #[cfg(unix)]
        {
            assert!(read_text(Path::new("/dev/zero")).unwrap_err().to_string().contains("never end"));
            write(Path::new("/dev/null"), "gone").unwrap();
        }
    }

    #[test]
    fn the_mark_of_windows_is_no_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        for (bytes, text) in
            [("\u{feff}a = 1\r\n", "a = 1\r\n"), ("\u{feff}", ""), ("a\u{feff}", "a\u{feff}")]
        {
            fs::write(&path, bytes).unwrap();
            assert_eq!(read_text(&path).unwrap(), text);
        }
        assert!(is_there(&path) && is_there(folder.path()) && !is_there(&folder.path().join("none")));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_rights_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [target, link] = ["target", "link"].map(|name| folder.path().join(name));
        fs::write(&target, "old").unwrap();
        fs::set_permissions(&target, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&target, &link).unwrap();
        write(&link, "new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
        let early = folder.path().join("early");
        symlink("not there yet", &early).unwrap();
        write(&early, "new").unwrap();
        assert!(fs::symlink_metadata(&early).unwrap().is_symlink());
        assert_eq!(read_text(&folder.path().join("not there yet")).unwrap(), "new");
        assert_eq!(fs::metadata(&target).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
