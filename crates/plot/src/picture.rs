//! A finished picture.

use std::{io::Read, path::Path};

use visloc_core::files;

use crate::PlotError;

/// Stands in every picture, near its beginning, so that those of an earlier run are known from somebody else's.
pub(crate) const MARK: &str = "<!-- visloc -->";
/// It stands before this byte.
const MARK_BEFORE: u64 = 1024;
/// The same for a PNG: a chunk of text, "Software: visloc", with its length before it and its checksum behind it.
const PNG_MARK: &[u8] = b"\x00\x00\x00\x0ftEXtSoftware\x00visloc\x96\xdc\xde\xc7";
/// Signature and header of a PNG have so many bytes.
#[cfg(feature = "png")]
const PNG_HEADER_BYTES: usize = 33;

/// A finished picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    svg: String,
}

impl Picture {
    /// Pixels of a saved PNG per unit of the SVG: sharp on screens of high resolution and in print.
    pub const SAVED_PNG_SCALE: f32 = 2.0;

    /// Longest side of a PNG, pixels: 16384 x 16384 x 4 bytes are 1 GB.
    #[cfg(feature = "png")]
    const MAX_SIDE_PX: f32 = 16384.0;

    pub(crate) fn new(svg: String) -> Self {
        Self { svg }
    }

    /// The picture as text of an SVG file.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The picture as bytes of a PNG file, `scale` pixels per unit of the SVG.
    ///
    /// # Errors
    /// If the scale is not a positive number or the result has more than 16384 pixels along a side.
    #[cfg(feature = "png")]
    pub fn png(&self, scale: f32) -> Result<Vec<u8>, PlotError> {
        use resvg::{tiny_skia, usvg};
        let options = usvg::Options { fontdb: crate::font::database(), ..usvg::Options::default() };
        let tree = usvg::Tree::from_str(&self.svg, &options)?;
        let size = tree.size();
        let (width_px, height_px) = (size.width(), size.height());
        let refused = PlotError::Scale { scale, width_px, height_px, max_px: Self::MAX_SIDE_PX };
        let longest_px = scale * width_px.max(height_px);
        if !(scale > 0.0 && longest_px <= Self::MAX_SIDE_PX) {
            return Err(refused);
        }
        let to_pixels = |length: f32| (length * scale).round().max(1.0) as u32;
        let pixels = tiny_skia::Pixmap::new(to_pixels(width_px), to_pixels(height_px));
        let mut pixels = pixels.ok_or(refused)?;
        let transform = tiny_skia::Transform::from_scale(scale, scale);
        resvg::render(&tree, transform, &mut pixels.as_mut());
        let mut png = pixels.encode_png().map_err(|error| PlotError::Png(error.to_string()))?;
        png.splice(PNG_HEADER_BYTES..PNG_HEADER_BYTES, PNG_MARK.iter().copied());
        Ok(png)
    }

    /// Writes `name.svg` into `dir`, which is made if missing, and with the feature `png` also `name.png`. They replace those of an
    /// earlier run; somebody else's files of these names are kept as `name.svg~` and `name.png~`.
    ///
    /// # Errors
    /// If a file cannot be written or the PNG would be too large.
    pub fn save(&self, dir: &Path, name: &str) -> Result<(), PlotError> {
        let path = |extension: &str| dir.join(format!("{name}.{extension}"));
        let write = |extension: &str, bytes: &[u8]| {
            let path = path(extension);
            let written =
                if is_own(&path) { files::replace(&path, bytes) } else { files::write(&path, bytes) };
            written.map_err(|source| PlotError::Write { path, source })
        };
        #[cfg(feature = "png")]
        let png = self.png(Self::SAVED_PNG_SCALE)?;
        write("svg", self.svg.as_bytes())?;
        #[cfg(feature = "png")]
        write("png", &png)?;
        Ok(())
    }
}

/// Whether a picture was drawn here.
fn is_own(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = files::open(path).and_then(|file| file.take(MARK_BEFORE).read_to_end(&mut start));
    let has = |mark: &[u8]| start.windows(mark.len()).any(|bytes| bytes == mark);
    read.is_ok() && (has(MARK.as_bytes()) || has(PNG_MARK))
}

/// Removes pictures of an earlier run from a folder, so that they are not taken for those of this one: those whose names, without the ending,
/// are to go. A PNG without an SVG of its name stays, too, and so does what cannot be removed.
pub fn remove_earlier(dir: &Path, is_to_go: impl Fn(&str) -> bool) {
    let Ok(entries) = std::fs::read_dir(dir) else { return };
    for svg in entries.flatten().map(|entry| entry.path()) {
        let is_svg = svg.extension().is_some_and(|ending| ending == "svg");
        if is_svg && is_own(&svg) && svg.file_stem().and_then(|stem| stem.to_str()).is_some_and(&is_to_go) {
            let png = svg.with_extension("png");
            if is_own(&png) {
                let _ = std::fs::remove_file(png);
            }
            let _ = std::fs::remove_file(svg);
        }
    }
}

/// Whether a name is that of a picture of a series: `prefix`, then digits.
pub fn is_of_series(name: &str, prefix: &str) -> bool {
    let digits = |rest: &str| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit());
    name.strip_prefix(prefix).is_some_and(digits)
}

#[cfg(test)]
impl Picture {
    /// Whether other programs can draw it.
    pub(crate) fn is_valid_svg(&self) -> bool {
        resvg::usvg::Tree::from_str(&self.svg, &resvg::usvg::Options::default()).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pictures_of_an_earlier_run_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["frame-07.svg", "frame-07.png", "frame-08.png", "frame-x.svg", "map.svg"];
        names.iter().for_each(|name| std::fs::write(folder.path().join(name), MARK).unwrap());
        std::fs::write(folder.path().join("frame-09.svg"), "<svg/>").unwrap();
        remove_earlier(folder.path(), |name| is_of_series(name, "frame-"));
        let is_left = |name: &&&str| folder.path().join(name).exists();
        assert_eq!(names.iter().filter(is_left).count(), 3);
        assert!(!folder.path().join("frame-07.png").exists() && folder.path().join("frame-08.png").exists());
        assert!(folder.path().join("frame-09.svg").exists(), "somebody else's");
    }

    #[test]
    fn only_pictures_of_somebody_else_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        ["map.svg", "map.png"].iter().for_each(|name| std::fs::write(path(name), "precious").unwrap());
        let picture = Picture::new(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">{MARK}</svg>"
        ));
        for run in 0..2 {
            picture.save(folder.path(), "map").unwrap();
            let kept = std::fs::read_to_string(path("map.svg~")).unwrap();
            assert_eq!((kept.as_str(), path("map.svg~~").exists()), ("precious", false), "run {run}");
        }
        assert_eq!(std::fs::read_to_string(path("map.svg")).unwrap(), picture.svg());
        #[cfg(feature = "png")]
        assert_eq!(std::fs::read_to_string(path("map.png~")).unwrap(), "precious");
    }

    #[cfg(feature = "png")]
    #[test]
    fn a_photo_beside_a_drawing_of_its_name_is_somebody_elses() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let picture = Picture::new(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">{MARK}</svg>"
        ));
        picture.save(folder.path(), "map").unwrap();
        let png = std::fs::read(path("map.png")).unwrap();
        let pixels = resvg::tiny_skia::Pixmap::decode_png(&png).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (18, 18), "the mark harms nothing");
        picture.save(folder.path(), "map").unwrap();
        assert!(!path("map.png~").exists(), "the one of before goes");
        std::fs::write(path("map.png"), "precious").unwrap();
        picture.save(folder.path(), "map").unwrap();
        assert_eq!(std::fs::read_to_string(path("map.png~")).unwrap(), "precious");
        std::fs::write(path("map.png"), "precious, too").unwrap();
        remove_earlier(folder.path(), |name| name == "map");
        assert!(path("map.png").exists() && !path("map.svg").exists());
    }
}
