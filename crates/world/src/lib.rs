//! Known maps. A map is a TOML file in `maps/` whose `kind` says which world it describes.

pub mod field;
mod hindrance;
#[cfg(feature = "import")]
pub mod import;
mod load;
pub mod office;

pub use hindrance::Hindrance;
pub use load::{BUILT_IN_MAPS, Map, MapError};
