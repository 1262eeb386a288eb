//! The algorithms by name. A new algorithm adds its folder and one entry here.

use visloc_core::settings::{Parameter, Settings, SettingsError, commented_toml, overlay, parameters};

use crate::{
    ConfigError, Localizer, ObservationModel,
    evolutionary::{Evolutionary, EvolutionaryConfig, ExplorerConfig, ExplorerKind},
    markov::{Markov, MarkovConfig},
    monte_carlo::{MonteCarlo, MonteCarloConfig},
};

/// Makes a localizer from its name, parameters that lie over its defaults in this order, and a model.
type Build = fn(&str, &[&str], Box<dyn ObservationModel>) -> Result<Box<dyn Localizer>, ConfigError>;

/// Names and meanings of an algorithm's parameters, with parameters that lie over its defaults in this order.
type Describe = fn(&str, &[&str]) -> Result<Vec<Parameter>, ConfigError>;

/// An algorithm that can be chosen by name.
#[derive(Debug, Clone, Copy)]
pub struct AlgorithmInfo {
    /// The name.
    pub name: &'static str,
    /// One line about it.
    pub summary: &'static str,
    build: Build,
    defaults: fn() -> Result<String, SettingsError>,
    describe: Describe,
}

/// A particle filter by the function that makes its parameters.
macro_rules! monte_carlo_info {
    ($name:literal, $summary:literal, $config:ident) => {
        AlgorithmInfo {
            name: $name,
            summary: $summary,
            build: |name, text, model| {
                let config = parse(name, text, MonteCarloConfig::$config())?;
                Ok(Box::new(MonteCarlo::new(config, model)?))
            },
            defaults: || commented_toml(&MonteCarloConfig::$config()),
            describe: |name, text| described(name, text, MonteCarloConfig::$config()),
        }
    };
}

/// All algorithms.
pub const ALGORITHMS: [AlgorithmInfo; 9] = [
    AlgorithmInfo {
        name: "evolutionary",
        summary: "races of exploiters around several hypotheses, random explorers (thesis of 2017)",
        build: |name, text, model| {
            Ok(Box::new(Evolutionary::new(parse(name, text, evolutionary())?, model)?))
        },
        defaults: || commented_toml(&evolutionary()),
        describe: |name, text| described(name, text, evolutionary()),
    },
    AlgorithmInfo {
        name: "evolutionary-grid",
        summary: "the same with explorers on a fixed grid (thesis of 2010)",
        build: |name, text, model| {
            Ok(Box::new(Evolutionary::new(parse(name, text, evolutionary_grid())?, model)?))
        },
        defaults: || commented_toml(&evolutionary_grid()),
        describe: |name, text| described(name, text, evolutionary_grid()),
    },
    monte_carlo_info!("mce", "Monte Carlo with elitism: the best particles survive unchanged", default),
    monte_carlo_info!("mc", "classic Monte Carlo", classic),
    monte_carlo_info!("mca", "augmented: random particles when the images fit worse than before", augmented),
    monte_carlo_info!("mcae", "augmented Monte Carlo with elitism", augmented_elite),
    monte_carlo_info!("kld", "as many particles as needed, and a minimum for each hypothesis", kld),
    monte_carlo_info!("mc-systematic", "classic Monte Carlo with systematic resampling", systematic),
    AlgorithmInfo {
        name: "markov",
        summary: "belief over a grid of tiles and headings, from goals as a whole; accurate to a tile",
        build: |name, text, model| {
            Ok(Box::new(Markov::new(parse(name, text, MarkovConfig::default())?, model.as_ref())?))
        },
        defaults: || commented_toml(&MarkovConfig::default()),
        describe: |name, text| described(name, text, MarkovConfig::default()),
    },
];

fn evolutionary() -> EvolutionaryConfig {
    EvolutionaryConfig::default()
}

fn evolutionary_grid() -> EvolutionaryConfig {
    let explorers = ExplorerConfig { kind: ExplorerKind::Grid, ..ExplorerConfig::default() };
    EvolutionaryConfig { explorers, ..EvolutionaryConfig::default() }
}

/// A localizer by name. `config_toml` overrides some or all of its default parameters.
///
/// # Errors
/// If there is no such algorithm or a parameter is unknown or out of its range.
pub fn build_localizer(
    name: &str,
    config_toml: Option<&str>,
    model: Box<dyn ObservationModel>,
) -> Result<Box<dyn Localizer>, ConfigError> {
    build_layered(name, config_toml.as_slice(), model)
}

/// A localizer by name. Each of the `layers` overrides some or all of the parameters before it, the first one those of
/// the algorithm's defaults.
///
/// # Errors
/// As [`build_localizer`].
pub(crate) fn build_layered(
    name: &str,
    layers: &[&str],
    model: Box<dyn ObservationModel>,
) -> Result<Box<dyn Localizer>, ConfigError> {
    (find(name)?.build)(name, layers, model)
}

/// The default parameters of an algorithm as TOML, each with its meaning as a comment.
///
/// # Errors
/// If there is no such algorithm.
pub fn default_config_toml(name: &str) -> Result<String, ConfigError> {
    (find(name)?.defaults)().map_err(|error| ConfigError::from_settings(name, error))
}

/// The parameters of an algorithm one by one. Each of the `layers` overrides some of those before it.
///
/// # Errors
/// If there is no such algorithm, or a layer has a mistake.
pub(crate) fn describe_layered(name: &str, layers: &[&str]) -> Result<Vec<Parameter>, ConfigError> {
    (find(name)?.describe)(name, layers)
}

fn described<C: Settings>(name: &str, layers: &[&str], defaults: C) -> Result<Vec<Parameter>, ConfigError> {
    let config = parse(name, layers, defaults)?;
    parameters(&config).map_err(|error| ConfigError::from_settings(name, error))
}

fn find(name: &str) -> Result<&'static AlgorithmInfo, ConfigError> {
    ALGORITHMS.iter().find(|algorithm| algorithm.name == name).ok_or_else(|| ConfigError::UnknownAlgorithm {
        name: name.to_owned(),
        known: ALGORITHMS.map(|algorithm| algorithm.name).join(", "),
    })
}

/// Lays the given parameters over the defaults of the algorithm, so that a file may name only what it changes.
fn parse<C: Settings>(name: &str, layers: &[&str], defaults: C) -> Result<C, ConfigError> {
    layers.iter().try_fold(defaults, |below, text| {
        overlay(&below, text).map_err(|error| ConfigError::from_settings(name, error))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_algorithm_lists_the_known_ones() {
        let error = default_config_toml("kalman").unwrap_err().to_string();
        assert_eq!(
            error,
            "unknown algorithm \"kalman\"; known: evolutionary, evolutionary-grid, mce, mc, mca, mcae, kld, mc-systematic, markov"
        );
    }

    #[test]
    fn a_file_changes_only_what_it_names() {
        let text = "num_particles = 500\n[motion]\nnoise_m_per_m = 0.5\n";
        let config = parse("mc", &[text], MonteCarloConfig::classic()).unwrap();
        assert_eq!(config.num_particles, 500);
        assert!((config.motion.noise_m_per_m - 0.5).abs() < 1e-12);
        assert!(config.elite_share.abs() < 1e-12, "still the classic filter");
    }

    #[test]
    fn unknown_keys_are_refused_with_their_line() {
        let error =
            parse("mc", &["\nnum_partikles = 5\n"], MonteCarloConfig::classic()).unwrap_err().to_string();
        assert_eq!(
            error,
            "configuration of mc, line 2: unknown key `num_partikles`, did you mean `num_particles`?"
        );
    }

    #[test]
    fn defaults_round_trip() {
        for algorithm in ALGORITHMS {
            let text = default_config_toml(algorithm.name).unwrap();
            assert!(text.contains("[motion]"), "{text}");
            let is_explained = |lines: &[&str]| !lines[1].contains(" = ") || lines[0].starts_with('#');
            let lines: Vec<&str> = text.lines().collect();
            assert!(lines.windows(2).all(is_explained), "{text}");
        }
        let text = default_config_toml("evolutionary-grid").unwrap();
        assert_eq!(parse("evolutionary", &[&text], evolutionary()).unwrap(), evolutionary_grid());
    }
}
