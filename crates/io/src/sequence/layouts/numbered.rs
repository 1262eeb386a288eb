//! Images whose names are numbers.

use std::{
    fs,
    path::{Path, PathBuf},
};

use visloc_core::Timestamp;

use crate::FileError;

/// All PNG and JPEG files of a folder, in the order of all numbers in their names: 2 comes before 10.
///
/// # Errors
/// If the folder cannot be read.
pub fn image_files(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(FileError::io(folder))? {
        let path = entry.map_err(FileError::io(folder))?.path();
        if is_image(&path) && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort_by_cached_key(|path| (in_pieces(path), path.clone()));
    Ok(paths)
}

/// A piece of a name: a number, or what is between two of them. What is too long for a number is text.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Piece {
    Number(u128),
    Text(String),
}

/// The name of a file, piece by piece.
fn in_pieces(path: &Path) -> Vec<Piece> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let chars: Vec<char> = stem.chars().collect();
    let pieces = chars.chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit());
    let piece = |piece: &[char]| {
        let text: String = piece.iter().collect();
        text.parse().map_or(Piece::Text(text), Piece::Number)
    };
    pieces.map(piece).collect()
}

/// When an image was taken, by its number: datasets without times have 30 a second.
pub(super) fn at_number(number: f64) -> Timestamp {
    Timestamp::from_secs(number / 30.0)
}

/// Whether a folder has images.
pub(super) fn has_images(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|mut entries| entries.any(|e| e.is_ok_and(|e| is_image(&e.path()))))
}

/// Whether a file is a picture that can be read, by its name. Hidden files, notes of a system about others for instance, are none.
pub fn is_image(path: &Path) -> bool {
    let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    !is_hidden && matches!(ending(path).as_str(), "png" | "jpg" | "jpeg")
}

fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Where the images may be, and what to do, for a folder without any that can be read; empty if there is nothing to say.
pub fn instead_of_images(folder: &Path) -> String {
    const OTHERS: [&str; 12] =
        ["heic", "heif", "avif", "tif", "tiff", "bmp", "webp", "gif", "pgm", "ppm", "dng", "raw"];
    let Ok(entries) = fs::read_dir(folder) else { return String::new() };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    let count = |wanted: &str| paths.iter().filter(|path| ending(path) == wanted).count();
    let most = OTHERS.into_iter().map(|other| (count(other), other)).max_by_key(|(count, _)| *count);
    if let Some((count @ 1.., other)) = most {
        return format!("; it has {count} .{other} files: convert them to JPEG or PNG");
    }
    match paths.iter().find(|path| has_images(path)) {
        Some(below) => format!("; images are in {}: name that folder", below.display()),
        None => String::new(),
    }
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

    #[test]
    fn images_come_in_the_order_of_all_numbers_in_their_names() {
        let orders: [&[&str]; 4] = [
            &["2.png", "10.png", "011.png"],
            &["clip1_frame9.jpg", "clip1_frame10.jpg", "clip2_frame0.jpg"],
            &["2024-05-01_12-00-00.900.jpg", "2024-05-01_12-00-01.000.jpg", "2024-05-01_12-00-01.100.jpg"],
            &["IMG_1.jpg", "IMG_2 (1).jpg", "IMG_2 (2).jpg", "IMG_10.jpg"],
        ];
        for order in orders {
            let folder = tempfile::tempdir().unwrap();
            order.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
            let paths = image_files(folder.path()).unwrap();
            let names: Vec<_> =
                paths.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
            assert_eq!(names, order);
        }
    }

    #[test]
    fn what_is_no_image_here_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let add = |name: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        };
        add("._0001.jpg");
        assert!(!has_images(folder.path()) && instead_of_images(folder.path()).is_empty());
        add("part0/0001.jpg");
        assert!(instead_of_images(folder.path()).contains("part0: name that folder"));
        ["a.HEIC", "b.heic", "c.bmp"].into_iter().for_each(add);
        assert!(instead_of_images(folder.path()).contains("2 .heic files: convert them to JPEG or PNG"));
    }
}
