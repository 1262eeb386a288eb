//! Reading a map by name or from a file.

use std::{io::ErrorKind, path::Path};

use serde::Deserialize;
use thiserror::Error;
use visloc_core::files;

use crate::{
    field::{Field, is_field_list, read_field_list},
    office::{
        Office,
        import::{Import, ImportNote, is_grid, read_dxf, read_grid, read_list, read_picture, read_svg},
    },
};

/// Longer files are no maps, bytes.
const MAX_BYTES: u64 = 1 << 26;

/// Maps that are part of the program: name and text.
pub const BUILT_IN_MAPS: [(&str, &str); 5] = [
    ("robocup-spl-2010", include_str!("../../../maps/robocup-spl-2010.toml")),
    ("robocup-spl-2024", include_str!("../../../maps/robocup-spl-2024.toml")),
    ("office", include_str!("../../../maps/office.toml")),
    ("office-large", include_str!("../../../maps/office-large.toml")),
    ("office-repeated", include_str!("../../../maps/office-repeated.toml")),
];

/// A map that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MapError {
    /// The file cannot be read, and it is not the name of a built-in map either.
    #[error("map {name}: {}", unreadable(source))]
    Unreadable {
        /// What the user wrote.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not TOML, or a key is missing, unknown or of the wrong type.
    #[error("map {name}{}: {reason}", line.map(|l| format!(", line {l}")).unwrap_or_default())]
    Syntax {
        /// File or name.
        name: String,
        /// Line of the text, from 1.
        line: Option<usize>,
        /// What was expected and found.
        reason: String,
    },
    /// A value that no world can have.
    #[error("map {name}: {key}: expected {expected}, found {found}")]
    Value {
        /// File or name.
        name: String,
        /// The key.
        key: String,
        /// What is allowed.
        expected: &'static str,
        /// What the file says.
        found: String,
    },
}

fn unreadable(source: &std::io::Error) -> String {
    match source.kind() {
        ErrorKind::NotFound => format!("{source}; expected a file or one of: {}", built_in_names()),
        _ => source.to_string(),
    }
}

fn built_in_names() -> String {
    BUILT_IN_MAPS.map(|(name, _)| name).join(", ")
}

/// A world that a localizer can work in.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Map {
    /// A RoboCup field.
    Field(Field),
    /// A building from inside.
    Office(Office),
}

#[derive(Deserialize)]
struct Kind {
    kind: Option<String>,
}

impl Map {
    /// A built-in map by name, or else a file.
    ///
    /// # Errors
    /// If there is no such map, or it has mistakes; the error names the file, the line and the key.
    pub fn load(name_or_path: &str) -> Result<Self, MapError> {
        if let Some((name, text)) = BUILT_IN_MAPS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(name, text);
        }
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

    /// A map from its text; `name` is used in errors.
    ///
    /// # Errors
    /// As [`Map::load`].
    pub fn parse(name: &str, text: &str) -> Result<Self, MapError> {
        let kind: Kind = toml::from_str(text).map_err(|e| syntax_error(name, text, &e))?;
        match kind.kind.as_deref() {
            Some("robocup-field") => Ok(Self::Field(Field::parse(name, text)?)),
            Some("office") => Ok(Self::Office(Office::parse(name, text)?)),
            other => Err(MapError::Value {
                name: name.to_owned(),
                key: "kind".to_owned(),
                expected: "\"robocup-field\" or \"office\"",
                found: other.map_or("nothing".to_owned(), |other| format!("{other:?}")),
            }),
        }
    }

    /// The map as text that [`Map::parse`] reads back to the same map.
    ///
    /// # Errors
    /// If it cannot be written; never for a map that was read.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        match self {
            Self::Field(field) => toml::to_string(field.dimensions()),
            Self::Office(office) => office.plan().to_toml(),
        }
    }

    /// The name that the map gives itself.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Field(field) => &field.dimensions().name,
            Self::Office(office) => &office.plan().name,
        }
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
            _ if bytes.starts_with(b"AutoCAD Binary DXF") => Self::Dxf,
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

pub(crate) fn syntax_error(name: &str, text: &str, error: &toml::de::Error) -> MapError {
    let line = error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1);
    MapError::Syntax { name: name.to_owned(), line, reason: error.message().to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_maps_load() {
        for (name, _) in BUILT_IN_MAPS {
            let map = Map::load(name).unwrap();
            assert_eq!(map.name(), name);
            assert_eq!(Map::parse("again", &map.to_toml().unwrap()).unwrap(), map);
        }
    }

    #[test]
    fn errors_name_the_place() {
        let (_, good) = BUILT_IN_MAPS[0];
        let error = |from: &str, to: &str| {
            assert!(good.contains(from));
            Map::parse("m.toml", &good.replace(from, to)).unwrap_err().to_string()
        };
        assert_eq!(
            error("width_m = 4.0", "width_m = -4.0"),
            "map m.toml: width_m: expected a length above 0, found -4"
        );
        assert!(error("border_m = 0.7", "").contains("missing field `border_m`"));
        assert!(error("border_m", "boarder_m").contains("line 10"));
        assert!(error("\"robocup-field\"", "\"moon\"").contains("kind: expected \"robocup-field\""));
        assert_eq!(
            Map::parse("m.toml", "").unwrap_err().to_string(),
            "map m.toml: kind: expected \"robocup-field\" or \"office\", found nothing"
        );
        assert!(error("inner_width_m = 1.4", "inner_width_m = 5.0").contains("goals.inner_width_m"));
        assert!(error("depth_m = 0.6", "depth_m = 3.5").contains("boxes[0].depth_m"));
        assert!(Map::load("no-such-map").unwrap_err().to_string().contains("robocup-spl-2010"));
    }
}
