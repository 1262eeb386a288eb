//! Known maps. A map is a TOML file in `maps/` whose `kind` says which world it describes.

mod built_in;
mod error;
pub mod field;
mod floor;
mod hindrance;
#[cfg(feature = "import")]
pub mod import;
mod load;
pub mod office;

pub use built_in::BUILT_IN_MAPS;
pub use error::MapError;
pub use hindrance::Hindrance;
pub use load::Map;
