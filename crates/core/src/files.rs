//! Files of the user: read with a bound, written so that an earlier file is never half lost.
//!
//! All files that visloc reads whole come through [`read`] and [`read_text`], all that it writes whole through
//! [`write()`] and [`NewFile`]. So no command can be hung up by a device that never ends, and none leaves a half
//! written file behind under its final name.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Read, Write},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

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
    let num_bytes = file.metadata()?.len();
    if num_bytes > max_bytes {
        return Err(too_long(max_bytes));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(num_bytes).unwrap_or(0));
    // A file may grow while it is read, and those of the system (/proc) say that they are empty.
    file.take(max_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes { Err(too_long(max_bytes)) } else { Ok(bytes) }
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
#[must_use]
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Whether anything has this name, be it a file or not. Who wants a file if there is one asks this, not whether it is a file: then a
/// folder, a device or a broken link of that name is refused by [`open`] and not silently passed over.
#[must_use]
pub fn is_there(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

fn too_long(max_bytes: u64) -> io::Error {
    let message = format!("expected at most {} MiB", max_bytes >> 20);
    io::Error::new(io::ErrorKind::FileTooLarge, message)
}

/// A file in the making. It gets its name when it is complete; until then a file that had the name before is untouched.
///
/// Devices and pipes are written to directly, and so are the streams that the program was given (`/dev/stdout`), whatever they lead
/// to. A symbolic link stays one: its target is replaced.
#[derive(Debug)]
pub struct NewFile {
    path: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    /// Removed when it is given up.
    Beside(BufWriter<NamedTempFile>),
    /// Visible as [`part_path`], and left there when it is given up.
    Part(BufWriter<File>),
    Direct(BufWriter<File>),
}

impl NewFile {
    /// Begins a file, and makes its folder.
    ///
    /// # Errors
    /// If the folder cannot be made or nothing can be written there, with what the system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::create_with(path, |path| {
            let mut builder = tempfile::Builder::new();
            let builder = with_usual_rights(builder.prefix(".visloc-").suffix(".part"));
            let beside = builder.tempfile_in(folder_of(path))?;
            keep_rights(path, beside.as_file());
            Ok(Sink::Beside(BufWriter::new(beside)))
        })
    }

    /// As [`NewFile::create`], for a file that grows during a long run: until it is complete it can be looked at as
    /// `NAME.part`, and if the program is killed it is still there. A part that an earlier run left is replaced.
    ///
    /// # Errors
    /// As [`NewFile::create`].
    pub fn create_growing(path: &Path) -> io::Result<Self> {
        Self::create_with(path, |path| {
            let part = part_path(path);
            // Removed first, so that a link of that name is not followed.
            match fs::remove_file(&part) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
            let file = File::create_new(&part)?;
            keep_rights(path, &file);
            Ok(Sink::Part(BufWriter::new(file)))
        })
    }

    fn create_with(path: &Path, open: impl FnOnce(&Path) -> io::Result<Sink>) -> io::Result<Self> {
        if let Some(stream) = own_stream(path)? {
            return Ok(Self { path: path.to_path_buf(), sink: Sink::Direct(BufWriter::new(stream)) });
        }
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if let Ok(found) = fs::metadata(&path) {
            refuse_folder(&found)?;
            // Who may not write a file must not replace it either, which the rights of the folder alone would allow.
            let writable = File::options().append(true).open(&path)?;
            if !found.is_file() {
                return Ok(Self { path, sink: Sink::Direct(BufWriter::new(writable)) });
            }
        }
        fs::create_dir_all(folder_of(&path))?;
        let sink = open(&path)?;
        Ok(Self { path, sink })
    }

    /// Gives the complete file its name.
    ///
    /// # Errors
    /// If the rest cannot be written; an earlier file is untouched then.
    pub fn finish(self) -> io::Result<()> {
        match self.sink {
            Sink::Direct(mut writer) => writer.flush(),
            Sink::Beside(writer) => {
                let beside = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
                beside.as_file().sync_data()?;
                beside.persist(&self.path).map(drop).map_err(|error| error.error)
            }
            Sink::Part(writer) => {
                writer.into_inner().map_err(io::IntoInnerError::into_error)?.sync_data()?;
                fs::rename(part_path(&self.path), &self.path)
            }
        }
    }
}

/// Where a file that grows is until it is complete: `NAME.part`.
#[must_use]
pub fn part_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn refuse_folder(found: &fs::Metadata) -> io::Result<()> {
    let message = "expected the name of a file, found a folder";
    if found.is_dir() { Err(io::Error::new(io::ErrorKind::IsADirectory, message)) } else { Ok(()) }
}

/// The new file may be read by whoever could read the old one.
fn keep_rights(old: &Path, new: &File) {
    if let Ok(found) = fs::metadata(old) {
        let _ = new.set_permissions(found.permissions());
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Beside(writer) => writer.write(bytes),
            Sink::Part(writer) | Sink::Direct(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Beside(writer) => writer.flush(),
            Sink::Part(writer) | Sink::Direct(writer) => writer.flush(),
        }
    }
}

/// Whether a file could be written at a path; leaves nothing behind.
///
/// # Errors
/// Why not, with what the system says.
pub fn try_file(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => File::options().append(true).open(path).map(drop)?,
        // Whoever opens a pipe for a moment ends it for its reader.
        Ok(found) => return refuse_folder(&found),
        Err(_) => {}
    }
    // A link is replaced where it leads to.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    try_folder(folder_of(&path))
}

/// Whether files could be written into a folder, which may have to be made; leaves nothing behind.
///
/// # Errors
/// Why not, with what the system says.
pub fn try_folder(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(found) if !found.is_dir() => {
            let message = format!("expected a folder, found that {} is none", path.display());
            Err(io::Error::new(io::ErrorKind::NotADirectory, message))
        }
        Ok(_) => tempfile::tempfile_in(path).map(drop),
        Err(error) if error.kind() == io::ErrorKind::NotFound && path != Path::new(".") => {
            try_folder(folder_of(path))
        }
        Err(error) => Err(error),
    }
}

/// Writes a whole file at once, and makes its folder.
///
/// # Errors
/// What the system says; an earlier file is untouched then.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = NewFile::create(path)?;
    file.write_all(bytes.as_ref())?;
    file.finish()
}

/// The stream of this program that a path such as `/dev/stdout` names. It may lead to a file, to which the shell or the program
/// writes as well, so that file must not be replaced.
#[cfg(unix)]
fn own_stream(path: &Path) -> io::Result<Option<File>> {
    use std::os::fd::AsFd;
    const MAX_LINKS: usize = 40;
    let Ok(streams) = fs::canonicalize("/dev/fd") else { return Ok(None) };
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        if fs::canonicalize(folder_of(&path)).is_ok_and(|folder| folder == streams) {
            // A copy of the stream goes on where it is; to open it once more would begin at another place.
            let copy = match path.file_name().and_then(|name| name.to_str()) {
                Some("1") => {
                    io::stdout().flush()?;
                    io::stdout().as_fd().try_clone_to_owned()?.into()
                }
                Some("2") => io::stderr().as_fd().try_clone_to_owned()?.into(),
                _ => File::options().append(true).open(&path)?,
            };
            return Ok(Some(copy));
        }
        let Ok(target) = fs::read_link(&path) else { return Ok(None) };
        path = folder_of(&path).join(target);
    }
    Ok(None)
}

#[cfg(not(unix))]
fn own_stream(_: &Path) -> io::Result<Option<File>> {
    Ok(None)
}

/// Temporary files are private unless told otherwise; an output is not. The user's mask still applies.
#[cfg(unix)]
fn with_usual_rights<'b, 'p, 's>(
    builder: &'b mut tempfile::Builder<'p, 's>,
) -> &'b mut tempfile::Builder<'p, 's> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn with_usual_rights<'b, 'p, 's>(
    builder: &'b mut tempfile::Builder<'p, 's>,
) -> &'b mut tempfile::Builder<'p, 's> {
    builder
}

#[cfg(test)]
mod tests {
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
    fn a_file_that_grows_can_be_looked_at_and_outlives_the_program() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        write(&path, "old").unwrap();
        for _ in 0..2 {
            let mut file = NewFile::create_growing(&path).unwrap();
            file.write_all(b"line").unwrap();
            file.flush().unwrap();
            drop(file);
            assert_eq!(read_text(&part_path(&path)).unwrap(), "line", "and is replaced the next time");
            assert_eq!(read_text(&path).unwrap(), "old");
        }
        let mut file = NewFile::create_growing(&path).unwrap();
        file.write_all(b"all lines").unwrap();
        file.finish().unwrap();
        assert_eq!(
            (names(folder.path()), read_text(&path).unwrap()),
            (vec!["table.csv".into()], "all lines".into())
        );
    }

    #[test]
    fn trying_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        write(&path("file"), "kept").unwrap();
        try_file(&path("a/b/new")).unwrap();
        try_file(&path("file")).unwrap();
        try_folder(&path("c/d")).unwrap();
        assert!(try_file(folder.path()).unwrap_err().to_string().contains("found a folder"));
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
        assert_eq!(fs::metadata(&target).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
