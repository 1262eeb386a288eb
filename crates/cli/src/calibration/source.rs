//! Where the pictures come from. Everything that calibrates asks here, so another kind of source is added in one place.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use visloc_base::GrayImage;
use visloc_data::image_codec::read_gray_image;

/// A picture that can be read.
#[derive(Debug, Clone)]
pub struct NamedImage {
    /// For people.
    pub name: String,
    path: PathBuf,
}

impl NamedImage {
    /// Reads it.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(&self) -> Result<GrayImage> {
        Ok(read_gray_image(&self.path)?)
    }
}

/// The pictures of a folder by name.
///
/// # Errors
/// If there is no such folder or it has no pictures.
pub fn open_images(source: &Path) -> Result<Vec<NamedImage>> {
    let entries = std::fs::read_dir(source)
        .with_context(|| format!("{}: expected a folder of images", source.display()))?;
    let is_image = |path: &PathBuf| {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        matches!(extension.as_deref(), Some("png" | "jpg" | "jpeg"))
    };
    let mut images: Vec<NamedImage> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(is_image)
        .map(|path| NamedImage {
            name: path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            path,
        })
        .collect();
    if images.is_empty() {
        bail!("{}: expected PNG or JPEG images, found none", source.display());
    }
    images.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(images)
}
