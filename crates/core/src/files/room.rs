//! Recordings leave room on their disk.

use std::{
    fs::File,
    io::{self, Seek, SeekFrom, Write},
};

/// So much of a disk is left, bytes: what a run has computed is still to be written then, and other programs live on the same disk.
const LEFT_BYTES: u64 = 16 << 20;
/// ... but no more than one of so many parts of what was free.
const LEFT_PARTS: u64 = 4;

/// A file that grows for long, and ends with an error like that of a full disk before the disk is full.
#[derive(Debug)]
pub struct GrowingFile {
    file: File,
    left_bytes: u64,
}

impl GrowingFile {
    /// Takes a file that is open for writing. Devices and pipes have no disk to fill.
    pub fn new(file: File) -> Self {
        let is_file = file.metadata().is_ok_and(|found| found.is_file());
        let free_bytes = free_bytes(&file).filter(|_| is_file).unwrap_or(0);
        Self { file, left_bytes: LEFT_BYTES.min(free_bytes / LEFT_PARTS) }
    }
}

impl Write for GrowingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let needed_bytes = self.left_bytes.saturating_add(bytes.len() as u64);
        if self.left_bytes > 0 && free_bytes(&self.file).is_some_and(|free_bytes| free_bytes < needed_bytes) {
            let message =
                format!("No space left on device, but for {} kB that are kept free", self.left_bytes / 1000);
            return Err(io::Error::new(io::ErrorKind::StorageFull, message));
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for GrowingFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// What a user may still write to the disk of a file, if the system tells it.
#[cfg(unix)]
fn free_bytes(file: &File) -> Option<u64> {
    let disk = rustix::fs::fstatvfs(file).ok()?;
    disk.f_bavail.checked_mul(disk.f_frsize)
}

#[cfg(not(unix))]
fn free_bytes(_: &File) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_fill_the_disk_is_refused_and_the_rest_written() {
        let mut growing = GrowingFile::new(tempfile::tempfile().unwrap());
        growing.write_all(b"fits").unwrap();
        if cfg!(unix) {
            growing.left_bytes = u64::MAX / 2;
            let error = growing.write(b"does not").unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
            assert_eq!(growing.file.metadata().unwrap().len(), 4);
        }
    }
}
