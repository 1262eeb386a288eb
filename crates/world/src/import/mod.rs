//! Maps from files: our own format, measures of a field, lists of walls and doors, occupancy grids, and drawings as SVG and DXF.
//!
//! Plans have one frame: x to the right, y up, meters. A reader takes the text or the bytes of a file and gives a plan
//! with notes on what it passed over.

mod doors;
mod drawing;
mod dxf;
mod field_list;
mod grid;
mod list;
mod load;
mod notes;
mod outline;
mod svg;
#[cfg(test)]
mod tests;
mod walls;

pub(crate) use dxf::read_dxf;
pub(crate) use grid::{is_grid, read_grid, read_picture};
pub(crate) use list::read_list;
pub(crate) use notes::Import;
pub use notes::ImportNote;
pub(crate) use svg::read_svg;

use crate::MapError;

/// What is wrong with a YAML text, without the place that the line number tells.
pub(crate) fn yaml_error(name: &str, error: &serde_saphyr::Error) -> MapError {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    let at = error.location();
    let place = at.map(|at| format!("line {} column {}: ", at.line(), at.column()));
    let reason = place.and_then(|place| first.split_once(&place)).map_or(first, |(_, reason)| reason);
    MapError::Syntax {
        name: name.to_owned(),
        line: at.map(|at| usize::try_from(at.line()).unwrap_or(usize::MAX)),
        reason: reason.to_owned(),
    }
}

/// That a drawing has nothing of a plan, with what it has instead.
fn found_nothing(expected: &str, notes: notes::Notes) -> String {
    const MAX_SHOWN: usize = 6;
    let notes = notes.into_vec();
    if notes.is_empty() {
        return format!("{expected}, found none");
    }
    let mut found: Vec<String> = notes.iter().take(MAX_SHOWN).map(ToString::to_string).collect();
    if notes.len() > MAX_SHOWN {
        found.push("...".to_owned());
    }
    format!("{expected}, found none; {}", found.join("; "))
}
