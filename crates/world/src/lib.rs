//! Known maps. A map is a TOML file in `maps/` whose `kind` says which world it describes.

mod built_in;
mod error;
pub mod field;
mod hindrance;
#[cfg(feature = "import")]
mod import;
mod load;
mod occupancy_grid;
pub mod office;

pub use built_in::BUILT_IN_MAPS;
pub use error::MapError;
pub use hindrance::Hindrance;
#[cfg(feature = "import")]
pub use import::ImportNote;
pub use load::Map;
