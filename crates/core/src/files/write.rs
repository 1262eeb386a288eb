//! Writing: a file gets its name when it is complete.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Read, Write},
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use tempfile::NamedTempFile;

use super::names::{
    MAX_LINKS, folder_of, kept_path, part_path, refuse_folder, refuse_folder_name, target_of,
};

/// How often a file that is being written is asked for again before it is refused, and how long is waited in between.
const CLAIM_TRIES: (u32, Duration) = (40, Duration::from_millis(5));
/// The same for the reader of a pipe: a shell starts both ends at once.
#[cfg(unix)]
const READER_TRIES: (u32, Duration) = (40, Duration::from_millis(50));
/// A file in the making. It gets its name when it is complete; until then a file that had the name before is untouched, and then it
/// is kept as [`kept_path`], unless it is empty or the same.
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
    Stream(BufWriter<Stream>),
}

/// A stream that the program was given. Who has stopped reading it (`| head`) does not want the rest.
#[derive(Debug)]
struct Stream(File);

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.0.write(bytes) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(bytes.len()),
            written => written,
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
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
            let beside = builder.tempfile_in(folder_of(path)).map_err(plain)?;
            keep_rights(path, beside.as_file());
            Ok(Sink::Beside(BufWriter::new(beside)))
        })
    }

    /// As [`NewFile::create`], for a file that grows during a long run: until it is complete it can be looked at as
    /// `NAME.part`, and if the program is killed it is still there. A part that was there is kept as `NAME.part~`.
    ///
    /// # Errors
    /// As [`NewFile::create`].
    pub fn create_growing(path: &Path) -> io::Result<Self> {
        Self::create_with(path, |path| {
            let part = part_path(path);
            // Moved away first, so that a link of that name is not followed.
            if let Ok(found) = fs::symlink_metadata(&part) {
                if found.is_file() {
                    claim(&File::options().append(true).open(&part)?)?;
                }
                let is_kept = found.is_file() && found.len() > 0;
                if is_kept { fs::rename(&part, kept_path(&part))? } else { fs::remove_file(&part)? }
            }
            let file = File::create_new(&part)?;
            claim(&file)?;
            keep_rights(path, &file);
            Ok(Sink::Part(BufWriter::new(file)))
        })
    }

    fn create_with(path: &Path, open: impl FnOnce(&Path) -> io::Result<Sink>) -> io::Result<Self> {
        if let Some(stream) = own_stream(path)? {
            return Ok(Self { path: path.to_path_buf(), sink: Sink::Stream(BufWriter::new(Stream(stream))) });
        }
        refuse_folder_name(path)?;
        let path = target_of(path);
        if let Ok(found) = fs::metadata(&path) {
            refuse_folder(&found)?;
            // Who may not write a file must not replace it either, which the rights of the folder alone would allow.
            let writable = open_to_write(&path, &found)?;
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
        self.finish_with(keep)
    }

    fn finish_with(self, before: impl FnOnce(&Path, &Path) -> io::Result<()>) -> io::Result<()> {
        match self.sink {
            Sink::Direct(mut writer) => writer.flush(),
            Sink::Stream(mut writer) => writer.flush(),
            Sink::Beside(writer) => {
                let beside = writer.into_inner().map_err(|error| plain(error.into_error()))?;
                beside.as_file().sync_data()?;
                before(&self.path, beside.path())?;
                beside.persist(&self.path).map(drop).map_err(|error| error.error)
            }
            Sink::Part(writer) => {
                writer.into_inner().map_err(io::IntoInnerError::into_error)?.sync_data()?;
                let part = part_path(&self.path);
                before(&self.path, &part)?;
                fs::rename(part, &self.path)
            }
        }
    }
}

/// Opens for writing what is there. A pipe that nobody reads would hold up the program for ever.
#[cfg(unix)]
fn open_to_write(path: &Path, found: &fs::Metadata) -> io::Result<File> {
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
    let open = || File::options().append(true).open(path);
    if !found.file_type().is_fifo() {
        return open();
    }
    let flags = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
    let no_reader = rustix::io::Errno::NXIO.raw_os_error();
    let (num_tries, pause) = READER_TRIES;
    for _ in 0..num_tries {
        match File::options().write(true).custom_flags(flags).open(path) {
            // While this one is open the other opens at once.
            Ok(_held) => return open(),
            Err(error) if error.raw_os_error() == Some(no_reader) => thread::sleep(pause),
            Err(error) => return Err(error),
        }
    }
    let message = "nobody reads this pipe; start the program that reads it first";
    Err(io::Error::new(io::ErrorKind::BrokenPipe, message))
}

#[cfg(not(unix))]
fn open_to_write(path: &Path, _: &fs::Metadata) -> io::Result<File> {
    File::options().append(true).open(path)
}

/// Makes a file that is written in place, or empties it, unless another program is writing it.
///
/// # Errors
/// What the system says, or that the file is being written.
pub fn create_alone(path: &Path) -> io::Result<File> {
    if let Ok(found) = fs::metadata(path)
        && !found.is_file()
    {
        return open_to_write(path, &found);
    }
    let file = File::options().create(true).truncate(false).write(true).open(path)?;
    claim(&file)?;
    file.set_len(0)?;
    Ok(file)
}

/// Keeps other programs from writing the file until it is closed. Where the system cannot do that, they may.
///
/// A program that this one is starting holds a copy of each open file until it runs, so a file that was closed a moment ago
/// may still be claimed: it is asked for again for [`CLAIM_TRIES`].
fn claim(file: &File) -> io::Result<()> {
    let (num_tries, pause) = CLAIM_TRIES;
    for _ in 0..num_tries {
        match file.try_lock() {
            Err(fs::TryLockError::WouldBlock) => thread::sleep(pause),
            _ => return Ok(()),
        }
    }
    Err(io::Error::new(io::ErrorKind::ResourceBusy, "another program is writing it"))
}

/// Gives a file that will be replaced a second name, and makes a copy where a file can have only one. At any moment it has its first
/// name. An empty one and one that comes again are not worth it: what is kept would be lost for them.
fn keep(path: &Path, new: &Path) -> io::Result<()> {
    let kept = kept_path(path);
    if !fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > 0)
        || is_same(path, new).unwrap_or(false)
    {
        return Ok(());
    }
    match fs::remove_file(&kept) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    fs::hard_link(path, &kept).or_else(|_| fs::copy(path, &kept).map(drop))
}

/// Whether two files have the same content.
fn is_same(a: &Path, b: &Path) -> io::Result<bool> {
    const PIECE_BYTES: usize = 1 << 16;
    let [mut a, mut b] = [File::open(a)?, File::open(b)?];
    let mut left = a.metadata()?.len();
    if left != b.metadata()?.len() {
        return Ok(false);
    }
    let mut pieces = [vec![0; PIECE_BYTES], vec![0; PIECE_BYTES]];
    while left > 0 {
        let num = usize::try_from(left).unwrap_or(usize::MAX).min(PIECE_BYTES);
        let [piece_a, piece_b] = &mut pieces;
        a.read_exact(&mut piece_a[..num])?;
        b.read_exact(&mut piece_b[..num])?;
        if piece_a[..num] != piece_b[..num] {
            return Ok(false);
        }
        left -= num as u64;
    }
    Ok(true)
}

/// What the system says, without the name of a temporary file that nobody knows.
fn plain(error: io::Error) -> io::Error {
    let text = error.get_ref().map(ToString::to_string);
    match text.as_deref().and_then(|text| text.rsplit_once(" at path ")) {
        Some((cause, _)) => io::Error::new(error.kind(), cause.to_owned()),
        None => error,
    }
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
            Sink::Beside(writer) => writer.write(bytes).map_err(plain),
            Sink::Part(writer) | Sink::Direct(writer) => writer.write(bytes),
            Sink::Stream(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Beside(writer) => writer.flush().map_err(plain),
            Sink::Part(writer) | Sink::Direct(writer) => writer.flush(),
            Sink::Stream(writer) => writer.flush(),
        }
    }
}

/// Whether a file could be written at a path; leaves nothing behind.
///
/// # Errors
/// Why not, with what the system says.
pub fn try_file(path: &Path) -> io::Result<()> {
    refuse_folder_name(path)?;
    for name in [part_path(path), kept_path(path), kept_path(&part_path(path))] {
        // Too long a name, for instance; that nothing is there yet is as it should be.
        match fs::symlink_metadata(&name) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            Ok(found) if found.is_dir() => {
                let message = format!("it needs the name {}, found a folder of that name", name.display());
                return Err(io::Error::new(io::ErrorKind::IsADirectory, message));
            }
            _ => {}
        }
    }
    match fs::metadata(path) {
        Ok(found) if found.is_file() => {
            claim(&File::options().append(true).open(path)?)?;
        }
        // Whoever opens a pipe for a moment ends it for its reader.
        Ok(found) => return refuse_folder(&found),
        Err(_) => {}
    }
    // A link is replaced where it leads to.
    try_folder(folder_of(&target_of(path)))
}

/// Whether files could be written into a folder, which may have to be made; leaves nothing behind.
///
/// # Errors
/// Why not, with what the system says.
pub fn try_folder(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(found) if !found.is_dir() => {
            let message = format!("expected a folder, but {} is none", path.display());
            Err(io::Error::new(io::ErrorKind::NotADirectory, message))
        }
        // A disk that is full takes names, but no content.
        Ok(_) => tempfile::tempfile_in(path).and_then(|mut file| file.write_all(&[0])).map_err(plain),
        Err(error) if error.kind() == io::ErrorKind::NotFound && path != Path::new(".") => {
            try_folder(folder_of(path))
        }
        Err(error) => Err(error),
    }
}

/// Writes a whole file at once, and makes its folder. A file that was there is kept as [`kept_path`], unless it is empty or the same.
///
/// # Errors
/// What the system says; an earlier file is untouched then.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = NewFile::create(path)?;
    file.write_all(bytes.as_ref())?;
    file.finish()
}

/// As [`write()`], for files that can be made again from others, such as pictures: an earlier one is not kept.
///
/// # Errors
/// As [`write()`].
pub fn replace(path: &Path, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = NewFile::create(path)?;
    file.write_all(bytes.as_ref())?;
    file.finish_with(|_, _| Ok(()))
}

/// The stream of this program that a path such as `/dev/stdout` names. It may lead to a file, to which the shell or the program
/// writes as well, so that file must not be replaced.
#[cfg(unix)]
fn own_stream(path: &Path) -> io::Result<Option<File>> {
    use std::os::fd::AsFd;
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

    #[test]
    fn the_system_is_quoted_without_a_temporary_file() {
        let folder = Path::new("/dev/null/nothing");
        let error = tempfile::NamedTempFile::new_in(folder).unwrap_err();
        assert!(error.to_string().contains(" at path "), "as `plain` expects: {error}");
        let told = plain(error);
        assert_eq!(told.kind(), io::ErrorKind::NotADirectory);
        assert!(!told.to_string().contains("/dev/null"), "{told}");
    }
}
