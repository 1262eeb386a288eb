//! A building from inside: corridors between walls with doors, read from a file and checked.
//!
//! A plan (`plan`) is what a file says; [`Office`] is the geometry that comes of it: one-sided walls, doors and the
//! space where a robot can be.

pub(crate) mod check;
mod color;
mod free_space;
mod geometry;
mod plan;

pub use color::SurfaceColor;
pub use free_space::FreeSpace;
pub use geometry::{Door, Office, Wall};
pub use plan::{CorridorPlan, DoorPlan, OfficePlan, WallPlan, WallSides};

#[cfg(test)]
#[cfg(feature = "import")]
mod tests;
