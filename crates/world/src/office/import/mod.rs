//! Plans in other formats: lists of walls and doors, occupancy grids, and drawings as SVG and DXF.

mod drawing;
mod dxf;
mod grid;
mod list;
mod picture;
mod svg;
#[cfg(test)]
mod tests;

pub use dxf::read_dxf;
pub use grid::{is_grid, read_grid};
pub use list::read_list;
pub use svg::read_svg;
