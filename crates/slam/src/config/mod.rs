//! Every parameter, with unit, range, default and source; and the named sets of them.

mod error;
mod parameters;
mod presets;

pub use error::ConfigError;
pub use parameters::{
    Descriptor, FeatureConfig, MappingConfig, RelocationConfig, SlamConfig, StartConfig, TrackingConfig,
};
pub use presets::{PRESETS, SlamPreset};
