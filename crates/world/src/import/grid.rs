//! Occupancy grids of ROS' `map_server`: a YAML file beside a picture. The border of the free cells becomes outlines of
//! corridors, with walls where it meets occupied cells.
//!
//! Source: `nav2_map_server`, documentation of the map's YAML file and the modes `trinary`, `scale` and `raw`.

use std::{
    collections::BTreeMap,
    f64::consts::TAU,
    io::{self, Cursor},
    path::Path,
};

use image::{DynamicImage, GenericImageView, ImageFormat, ImageReader, Limits};
use serde::{Deserialize, de::IgnoredAny};
use visloc_core::files;

use super::{
    Import,
    drawing::MIN_BUILDING_M,
    notes::{Notes, Part},
    outline::{Cell, Cells, outlines},
    yaml_error,
};
use crate::{
    MapError,
    office::{OfficePlan, check::open_conflicting_sides},
};

/// The YAML file. The defaults are what `map_saver` writes.
#[derive(Deserialize)]
struct Grid {
    image: String,
    #[serde(default)]
    mode: Mode,
    resolution: f64,
    origin: [f64; 3],
    #[serde(default)]
    negate: Negate,
    #[serde(default = "default_occupied_thresh")]
    occupied_thresh: f64,
    #[serde(default = "default_free_thresh")]
    free_thresh: f64,
}

/// Its keys. `serde` would lose the lines of errors if it gathered the others.
const KEYS: [&str; 7] = ["image", "mode", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"];

/// How the values of the picture are meant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

/// Whether dark cells are free: a number or a truth value.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
enum Negate {
    Number(i64),
    Truth(bool),
}

impl Default for Negate {
    fn default() -> Self {
        Self::Truth(false)
    }
}

fn default_occupied_thresh() -> f64 {
    0.65
}

fn default_free_thresh() -> f64 {
    0.25
}

/// Longer files are no pictures of grids, bytes.
const MAX_BYTES: u64 = 1 << 28;
/// No grid is larger, cells.
const MAX_CELLS: u64 = 1 << 26;
/// What `map_saver` writes for unknown cells; its own default of `free_thresh` makes them free when they are read back.
const SAVED_UNKNOWN: [u8; 4] = [205, 205, 205, 255];

/// Whether a YAML text belongs to an occupancy grid rather than to a list of walls, which has none of these keys.
pub(crate) fn is_grid(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("image:") || line.starts_with("resolution:"))
}

/// The file of the picture of a grid, which lies beside its YAML file `name`.
pub(crate) fn read_picture(name: &str, image: &str) -> Result<Vec<u8>, String> {
    let path = Path::new(name).parent().unwrap_or(Path::new("")).join(image);
    files::read(&path, MAX_BYTES).map_err(|error| format!("{}: {error}", path.display()))
}

/// Reads a grid; `picture` gives the bytes of the picture that the YAML names, and `title` becomes the name of the map. A
/// grid has no doors: they are added to the map by hand.
pub(crate) fn read_grid(
    name: &str,
    title: &str,
    text: &str,
    picture: impl FnOnce(&str) -> Result<Vec<u8>, String>,
) -> Result<Import, MapError> {
    let grid: Grid = serde_saphyr::from_str(text).map_err(|error| yaml_error(name, &error))?;
    let refused = |key: &str, expected: &'static str, found: String| MapError::Value {
        name: name.to_owned(),
        key: key.to_owned(),
        expected,
        found,
    };
    grid.check().map_err(|(key, expected, found)| refused(key, expected, found))?;
    let not_read = |found: String| refused("image", "a PGM, PNG or BMP picture", found);
    let bytes = picture(&grid.image).map_err(not_read)?;
    let picture = decoded(&bytes).map_err(|reason| not_read(format!("{}: {reason}", grid.image)))?;
    let (width, height) = picture.dimensions();
    if f64::from(width.max(height)) * grid.resolution < MIN_BUILDING_M {
        let found = format!("{}, with {width} x {height} cells", grid.resolution);
        return Err(refused("resolution", "meters a cell, of a building of at least 1 m", found));
    }
    let mut notes = Notes::default();
    let keys: BTreeMap<String, IgnoredAny> = serde_saphyr::from_str(text).unwrap_or_default();
    notes.unknown_keys(keys.keys().filter(|key| !KEYS.contains(&key.as_str())), "an occupancy grid");
    let cells = grid.cells(&picture, &mut notes);
    let mut plan = OfficePlan::named(title);
    plan.corridors = outlines(&cells, grid.resolution, &mut notes).map_err(not_read)?;
    let (sin, cos) = grid.origin[2].sin_cos();
    for corner in plan.corridors.iter_mut().flat_map(|corridor| &mut corridor.outline) {
        let [x, y] = *corner;
        *corner = [grid.origin[0] + cos * x - sin * y, grid.origin[1] + sin * x + cos * y].map(readable);
    }
    for _ in 0..open_conflicting_sides(&mut plan) {
        let part = Part { what: "side of an outline on or across another one".to_owned(), ..Part::default() };
        notes.passed_over(&part, "a strip as narrow as its cells");
    }
    if plan.corridors.is_empty() {
        return Err(refused("image", "free cells", "none, after free_thresh, mode and negate".to_owned()));
    }
    Ok(Import { plan, notes: notes.into_vec() })
}

/// A length to a tenth of a millimeter, as people write it: far finer than any cell.
fn readable(length_m: f64) -> f64 {
    // Zero has no sign.
    (length_m * 1e4).round() / 1e4 + 0.0
}

impl Grid {
    fn check(&self) -> Result<(), (&'static str, &'static str, String)> {
        if !(self.resolution > 0.0 && self.resolution < 10.0) {
            return Err(("resolution", "meters a cell, above 0 and below 10", self.resolution.to_string()));
        }
        // More than a turn are degrees.
        let [x, y, yaw] = self.origin;
        let is_place = [x, y].iter().all(|value| value.abs() <= 1e6) && yaw.abs() <= TAU;
        if !is_place {
            return Err((
                "origin",
                "x and y in meters and an angle in radians",
                format!("{:?}", self.origin),
            ));
        }
        for (key, value) in [("free_thresh", self.free_thresh), ("occupied_thresh", self.occupied_thresh)] {
            if !(value > 0.0 && value <= 1.0) {
                return Err((key, "above 0, at most 1", value.to_string()));
            }
        }
        if self.occupied_thresh < self.free_thresh {
            return Err(("occupied_thresh", "at least free_thresh", self.occupied_thresh.to_string()));
        }
        match self.negate {
            Negate::Number(number) if !(0..=1).contains(&number) => {
                Err(("negate", "0, 1, false or true", number.to_string()))
            }
            _ => Ok(()),
        }
    }

    /// What `map_server` makes of every cell.
    fn cells(&self, picture: &DynamicImage, notes: &mut Notes) -> Cells {
        let has_alpha = picture.color().has_alpha();
        let is_saved = self.mode == Mode::Trinary && self.cell(SAVED_UNKNOWN, has_alpha) == Cell::Free;
        // 205 among 254 is what `map_saver` writes, and it means unknown.
        let is_saved =
            is_saved && !self.is_negated() && picture.pixels().any(|(_, _, p)| p.0[..3] == [254; 3]);
        let mut unknown = None;
        let cells = picture.pixels().map(|(x, y, pixel)| {
            if is_saved && pixel.0 == SAVED_UNKNOWN {
                unknown.get_or_insert((x, y));
                return Cell::Unknown;
            }
            self.cell(pixel.0, has_alpha)
        });
        let values = cells.collect();
        if unknown.is_some() {
            let part = Part {
                what: format!("picture with cells of 205 and free_thresh {}", self.free_thresh),
                ..Part::default()
            };
            notes.taken(&part, "205 as unknown, as map_saver writes it; map_server would take it for free");
        }
        Cells { width: picture.width() as usize, height: picture.height() as usize, values }
    }

    fn is_negated(&self) -> bool {
        matches!(self.negate, Negate::Truth(true) | Negate::Number(1))
    }

    /// One cell: red, green, blue and opacity.
    fn cell(&self, [red, green, blue, alpha]: [u8; 4], has_alpha: bool) -> Cell {
        let colors: f64 = [red, green, blue].map(f64::from).iter().sum();
        // Opacity counts as a channel in one of the modes.
        let brightness = if self.mode == Mode::Trinary && has_alpha {
            (colors + f64::from(alpha)) / (4.0 * 255.0)
        } else {
            colors / (3.0 * 255.0)
        };
        let occupied = if self.is_negated() { brightness } else { 1.0 - brightness };
        match self.mode {
            Mode::Scale if alpha != 255 => Cell::Unknown,
            // Between the thresholds lie the values from 0 to 100.
            Mode::Scale if (self.free_thresh..=self.occupied_thresh).contains(&occupied) => {
                let share = (occupied - self.free_thresh) / (self.occupied_thresh - self.free_thresh);
                match (100.0 * share).round_ties_even() {
                    0.0 => Cell::Free,
                    100.0 => Cell::Occupied,
                    _ => Cell::Unknown,
                }
            }
            Mode::Raw => {
                // The value is the probability in percent; above 100 it is unknown.
                let percent = (brightness * 255.0).round();
                if percent > 100.0 { Cell::Unknown } else { self.thresholded(percent / 100.0) }
            }
            _ => self.thresholded(occupied),
        }
    }

    fn thresholded(&self, occupied: f64) -> Cell {
        if self.occupied_thresh < occupied {
            Cell::Occupied
        } else if occupied < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}

/// The picture, after a look at its size.
fn decoded(bytes: &[u8]) -> Result<DynamicImage, String> {
    let text = |error: image::ImageError| error.to_string();
    let reader =
        || ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string());
    match reader()?.format() {
        Some(ImageFormat::Pnm | ImageFormat::Png | ImageFormat::Bmp) => {}
        other => return Err(other.map_or("another format".to_owned(), |format| format!("{format:?}"))),
    }
    let (width, height) = reader()?.into_dimensions().map_err(text)?;
    if width == 0 || height == 0 {
        return Err(format!("{width} x {height} cells: it is empty"));
    }
    if u64::from(width) * u64::from(height) > MAX_CELLS {
        return Err(format!("{width} x {height} cells, more than {MAX_CELLS}"));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(8 * MAX_CELLS + (1 << 20));
    let mut reader = reader()?;
    reader.limits(limits);
    reader.decode().map_err(|error| {
        let is_cut = matches!(&error, image::ImageError::IoError(cause) if cause.kind() == io::ErrorKind::UnexpectedEof);
        let reason = if is_cut { "the file ends before".to_owned() } else { error.to_string() };
        format!("{width} x {height} cells, but {reason}")
    })
}
