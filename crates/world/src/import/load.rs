//! Reading a map by name or from a file of any format.

use std::path::Path;

use visloc_core::files;

use super::{
    Import, ImportNote,
    field_list::{is_field_list, read_field_list},
    is_grid, read_dxf, read_grid, read_list, read_picture, read_svg,
};
use crate::{BUILT_IN_MAPS, Map, MapError, office::Office};

/// Longer files are no maps, bytes.
const MAX_BYTES: u64 = 1 << 26;

impl Map {
    /// A built-in map by name, or else a file.
    ///
    /// # Errors
    /// If there is no such map, or it has mistakes; the error names the file, the line and the key.
    pub fn load(name_or_path: &str) -> Result<Self, MapError> {
        Ok(Self::load_with_notes(name_or_path)?.0)
    }

    /// As [`Map::load`], with notes on what was passed over in a file of another format.
    ///
    /// # Errors
    /// As [`Map::load`].
    pub fn load_with_notes(name_or_path: &str) -> Result<(Self, Vec<ImportNote>), MapError> {
        if let Some((name, text)) = BUILT_IN_MAPS.iter().find(|(name, _)| *name == name_or_path) {
            return Ok((Self::parse(name, text)?, Vec::new()));
        }
        let bytes = files::read(Path::new(name_or_path), MAX_BYTES)
            .map_err(|source| MapError::Unreadable { name: name_or_path.to_owned(), source })?;
        let picture = |image: &str| read_picture(name_or_path, image);
        Self::from_bytes(name_or_path, &bytes, picture)
    }

    /// A map from the bytes of a file; `name` says which format it has, and is used in errors. `picture` gives the bytes of
    /// the picture that the file of an occupancy grid names.
    ///
    /// # Errors
    /// As [`Map::load`].
    pub fn from_bytes(
        name: &str,
        bytes: &[u8],
        picture: impl FnOnce(&str) -> Result<Vec<u8>, String>,
    ) -> Result<(Self, Vec<ImportNote>), MapError> {
        let not_text = |found: &str| MapError::Syntax {
            name: name.to_owned(),
            line: None,
            reason: format!("expected a map as text in UTF-8 (TOML, YAML, SVG) or DXF, found {found}"),
        };
        if bytes.is_empty() {
            return Err(not_text("an empty file"));
        }
        if name.ends_with(".vmap") {
            let reason = "expected a drawn map, found one of SLAM; such a map is for localize, slam --load and map info, align, merge, \
                          trim and export";
            return Err(MapError::Syntax { name: name.to_owned(), line: None, reason: reason.to_owned() });
        }
        let (title, bytes) = (stem(name), files::without_mark(bytes));
        let Import { plan, notes } = match Format::of(name, bytes) {
            Format::Dxf => read_dxf(name, title, bytes)?,
            Format::Picture => {
                return Err(not_text("a picture; give the YAML file of the occupancy grid beside it"));
            }
            format => {
                let text = std::str::from_utf8(bytes).map_err(|_| not_text("other data"))?;
                match format {
                    Format::Svg => read_svg(name, title, text)?,
                    Format::Yaml if is_field_list(text) => {
                        return Ok((Self::Field(read_field_list(name, title, text)?), Vec::new()));
                    }
                    Format::Yaml if is_grid(text) => read_grid(name, title, text, picture)?,
                    Format::Yaml => read_list(name, title, text)?,
                    _ => return Ok((Self::parse(name, text)?, Vec::new())),
                }
            }
        };
        Ok((Self::Office(Office::new(name, plan)?), notes))
    }
}

/// What kind of file a map is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Toml,
    Yaml,
    Svg,
    Dxf,
    Picture,
}

impl Format {
    /// By the ending of the name, unless the file begins with what only one format begins with.
    fn of(name: &str, bytes: &[u8]) -> Self {
        let extension = Path::new(name).extension().and_then(|extension| extension.to_str());
        let has_key = |key: &str| {
            let lines = bytes.split(|byte| *byte == b'\n').filter_map(|line| std::str::from_utf8(line).ok());
            lines
                .filter_map(|line| line.split_once('='))
                .any(|(left, _)| left == key || left.trim_end() == key)
        };
        match extension.map(str::to_ascii_lowercase).as_deref() {
            // A DWG is refused with what to do instead.
            _ if bytes.starts_with(b"AutoCAD Binary DXF") || bytes.starts_with(b"AC10") => Self::Dxf,
            _ if bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"P5") || bytes.starts_with(b"P2") => {
                Self::Picture
            }
            Some("svg") => Self::Svg,
            Some("dxf") => Self::Dxf,
            Some("yaml" | "yml") if has_key("kind") => Self::Toml,
            Some("yaml" | "yml") => Self::Yaml,
            Some("toml") => Self::Toml,
            _ if bytes.trim_ascii_start().starts_with(b"<") => Self::Svg,
            _ => Self::Toml,
        }
    }
}

/// Name of a file without folder and ending.
fn stem(path: &str) -> &str {
    Path::new(path).file_stem().and_then(|stem| stem.to_str()).unwrap_or(path)
}
