//! What a path leads to, however it is written.

use std::{
    fs,
    path::{Path, PathBuf},
};

use visloc_core::files;

/// Most files of a folder that are looked at.
const MAX_FILES: usize = 100_000;

/// The file or folder that a path leads to. Two paths are the same if they end at the same place, through links of either kind.
#[derive(Debug, Clone)]
pub struct Identity {
    path: PathBuf,
    kind: Kind,
    /// Device, number on it, and number of names.
    node: Option<(u64, u64, u64)>,
}

/// What is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Nothing yet.
    Missing,
    File,
    Folder,
    /// A device, a pipe or a socket.
    Device,
}

impl Identity {
    /// Follows a path.
    pub fn of(path: &Path) -> Self {
        let path = canonical(path);
        let found = fs::metadata(&path).ok();
        let kind = match &found {
            None => Kind::Missing,
            Some(found) if found.is_file() => Kind::File,
            Some(found) if found.is_dir() => Kind::Folder,
            Some(_) => Kind::Device,
        };
        Self { path, kind, node: found.as_ref().and_then(node) }
    }

    /// The path without links, as far as it exists.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is there.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Whether both lead to the same place.
    pub fn is(&self, other: &Self) -> bool {
        let is_node = |(device, number, _): (u64, u64, u64)| {
            other.node.is_some_and(|(d, n, _)| (d, n) == (device, number))
        };
        self.path == other.path || self.node.is_some_and(is_node)
    }

    /// Whether this is the very file that another one was, whatever their names.
    pub fn is_node_of(&self, other: &Self) -> bool {
        let file = |identity: &Self| identity.node.map(|(device, number, _)| (device, number));
        file(self).is_some() && file(self) == file(other)
    }

    /// Whether this is directly in a folder, which need not be there yet.
    pub fn is_in(&self, folder: &Self) -> bool {
        self.path.parent() == Some(&folder.path)
    }

    /// Whether the path leads to something below another one, be that there or not.
    pub fn is_below(&self, other: &Path) -> bool {
        self.path != other && self.path.starts_with(other)
    }

    /// Whether this is below a folder, or a file there has another name for it.
    pub fn is_inside(&self, folder: &Self) -> bool {
        if folder.kind != Kind::Folder || self.is(folder) {
            return false;
        }
        self.path.starts_with(&folder.path) || folder.has(self)
    }

    /// Whether a file below a folder is another one, or a link there leads to it.
    fn has(&self, other: &Self) -> bool {
        let has_other_names = other.node.is_some_and(|(.., names)| names > 1);
        let mut folders = vec![self.path.clone()];
        let mut num_files = 0;
        while let Some(folder) = folders.pop() {
            for entry in entries(&folder) {
                num_files += 1;
                if num_files > MAX_FILES {
                    return false;
                }
                match entry.file_type() {
                    Ok(kind) if kind.is_dir() => folders.push(entry.path()),
                    Ok(kind) if kind.is_symlink() => {
                        let target = Self::of(&entry.path());
                        if target.is(other)
                            || (target.kind == Kind::Folder && other.path.starts_with(&target.path))
                        {
                            return true;
                        }
                    }
                    Ok(_) if has_other_names && Self::of(&entry.path()).is(other) => return true,
                    _ => {}
                }
            }
        }
        false
    }

    /// What is directly in a folder; nothing of anything else.
    pub fn entries(&self) -> impl Iterator<Item = PathBuf> {
        entries(&self.path).map(|entry| entry.path())
    }
}

fn entries(folder: &Path) -> impl Iterator<Item = fs::DirEntry> {
    fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok)
}

/// Without links, as far as the path exists. Folders that are missing will be made, and are no links then: `missing/..` leads back.
fn canonical(path: &Path) -> PathBuf {
    let path = files::target_of(path);
    if let Ok(path) = fs::canonicalize(&path) {
        return path;
    }
    let absolute = std::path::absolute(&path).unwrap_or(path);
    match (absolute.parent(), absolute.file_name()) {
        (Some(folder), Some(name)) => canonical(folder).join(name),
        (Some(folder), None) => canonical(folder).parent().map(Path::to_path_buf).unwrap_or(absolute),
        (None, _) => absolute,
    }
}

#[cfg(unix)]
fn node(found: &fs::Metadata) -> Option<(u64, u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((found.dev(), found.ino(), found.nlink()))
}

#[cfg(not(unix))]
fn node(_: &fs::Metadata) -> Option<(u64, u64, u64)> {
    None
}
