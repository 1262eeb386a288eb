//! Parameters as people read and write them: TOML that is laid over defaults, refused with the nearest known key if one
//! is unknown, a number is out of its range or a value counts for nothing, and shown with the meaning of every key.
//!
//! Names, meanings, choices, conditions and ranges come from the parameters' own types: their documentation is what the user reads, through
//! the schema that `schemars` derives. So they are written once.

mod commented;
mod error;
mod idle;
mod keys;
mod overlay;
mod overrides;
mod parameters;
mod plain;
mod schema;

pub use commented::commented_toml;
pub use error::SettingsError;
pub use idle::{Idle, idle, idle_at};
pub use keys::nearest_key;
pub use overlay::{check_ranges, lay, overlay};
pub use overrides::Overrides;
pub use parameters::{Choice, Parameter, parameters};
pub use plain::plain_words;
use schemars::JsonSchema;
use serde::{Serialize, de::DeserializeOwned};

/// Parameters: plain data with a derived schema.
pub trait Settings: Serialize + DeserializeOwned + JsonSchema {}

impl<T: Serialize + DeserializeOwned + JsonSchema> Settings for T {}

#[cfg(test)]
mod tests;
