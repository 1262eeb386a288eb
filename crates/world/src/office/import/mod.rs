//! Plans in other formats: lists of walls and doors, occupancy grids, and drawings as SVG and DXF.

mod drawing;
mod dxf;
mod grid;
mod list;
mod picture;
mod svg;
#[cfg(test)]
mod tests;

use crate::MapError;

pub use dxf::read_dxf;
pub use grid::{is_grid, read_grid};
pub use list::read_list;
pub use svg::read_svg;

/// What is wrong with a YAML text, without the place that the line number tells.
fn yaml_error(name: &str, error: &serde_saphyr::Error) -> MapError {
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
