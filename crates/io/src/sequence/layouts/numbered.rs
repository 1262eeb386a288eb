//! Images whose names are numbers.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::FileError;

/// All PNG and JPEG files of a folder, by the last number in their names and then by name.
pub(super) fn image_files(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(FileError::io(folder))? {
        let path = entry.map_err(FileError::io(folder))?.path();
        if is_image(&path) && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort_by_key(|path| (number_in(path), path.clone()));
    Ok(paths)
}

/// Whether a folder has images.
pub(super) fn has_images(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|mut entries| entries.any(|e| e.is_ok_and(|e| is_image(&e.path()))))
}

fn is_image(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    matches!(extension.as_deref(), Some("png" | "jpg" | "jpeg"))
}

/// The last number in the name of a file: 17 of `left-00017.png`.
pub(super) fn number_in(path: &Path) -> Option<u64> {
    let stem = path.file_stem()?.to_string_lossy().into_owned();
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |i| i + 1);
    stem.get(start..end)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_names() {
        let number = |name: &str| number_in(Path::new(name));
        assert_eq!(number("rgb/0017.png"), Some(17));
        assert_eq!(number("left12-00003_a.jpg"), Some(3));
        assert_eq!(number("image.png"), None);
    }
}
