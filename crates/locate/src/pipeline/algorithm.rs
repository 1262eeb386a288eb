//! The parameters that suit a map.

use visloc_core::settings::Parameter;
use visloc_world::Map;

use super::FeatureChoice;
use crate::{Algorithm, ConfigError, algorithm::in_building};

/// The parameters that an algorithm has on a map, one by one, with those that a text overrides.
///
/// # Errors
/// If there is no such algorithm or a parameter is unknown or out of its range.
pub fn algorithm_parameters(
    map: &Map,
    algorithm: &str,
    features: FeatureChoice,
    algorithm_toml: Option<&str>,
) -> Result<Vec<Parameter>, ConfigError> {
    let parameters = algorithm_on(map, algorithm, features, algorithm_toml)?.parameters();
    parameters.map_err(|error| ConfigError::from_settings(algorithm, error))
}

/// An algorithm with the parameters that suit a map, and those that a text overrides.
pub(crate) fn algorithm_on(
    map: &Map,
    name: &str,
    features: FeatureChoice,
    toml: Option<&str>,
) -> Result<Algorithm, ConfigError> {
    let algorithm = Algorithm::named(name)?.on_map(map, features);
    let changed = toml.map_or(Ok(algorithm), |text| algorithm.with_toml(text));
    changed.map_err(|error| ConfigError::from_settings(name, error))
}

impl Algorithm {
    /// The same with what suits a map: in a building many places look alike, which needs more hypotheses.
    #[must_use]
    pub fn on_map(self, map: &Map, features: FeatureChoice) -> Self {
        match map {
            Map::Office(_) => in_building(self, features == FeatureChoice::Rich),
            _ => self,
        }
    }
}
