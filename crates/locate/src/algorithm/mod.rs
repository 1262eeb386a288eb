//! The algorithms, by name and with their parameters. A new algorithm adds its folder, a variant and an entry here.

mod in_building;

pub use in_building::{in_building, refinement_defaults};
use visloc_core::settings::{Parameter, SettingsError, commented_toml, overlay, parameters};

use crate::{
    ConfigError, Localizer, ObservationModel,
    evolutionary::{Evolutionary, EvolutionaryConfig, ExplorerConfig, ExplorerKind},
    markov::{Markov, MarkovConfig},
    monte_carlo::{MonteCarlo, MonteCarloConfig},
};

/// An algorithm with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Algorithm {
    /// Races of exploiters around several hypotheses, and explorers that look for others.
    Evolutionary(EvolutionaryConfig),
    /// A particle filter.
    MonteCarlo(MonteCarloConfig),
    /// A belief over a grid of tiles and headings.
    Markov(MarkovConfig),
}

/// The same expression with the configuration of any algorithm.
macro_rules! with_config {
    ($algorithm:expr, $config:ident => $result:expr) => {
        match $algorithm {
            Algorithm::Evolutionary($config) => $result,
            Algorithm::MonteCarlo($config) => $result,
            Algorithm::Markov($config) => $result,
        }
    };
}

impl Algorithm {
    /// The algorithm of a name, with its default parameters.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn named(name: &str) -> Result<Self, ConfigError> {
        let known = || ALGORITHMS.map(|algorithm| algorithm.name).join(", ");
        let info = ALGORITHMS.iter().find(|algorithm| algorithm.name == name);
        info.map(|info| (info.algorithm)())
            .ok_or_else(|| ConfigError::UnknownAlgorithm { name: name.to_owned(), known: known() })
    }

    /// The same with some or all parameters replaced by those of a text of TOML.
    ///
    /// # Errors
    /// If a parameter is unknown or out of its range.
    pub fn with_toml(&self, text: &str) -> Result<Self, SettingsError> {
        Ok(match self {
            Self::Evolutionary(config) => Self::Evolutionary(overlay(config, text)?),
            Self::MonteCarlo(config) => Self::MonteCarlo(overlay(config, text)?),
            Self::Markov(config) => Self::Markov(overlay(config, text)?),
        })
    }

    /// All parameters as TOML, each with its meaning as a comment.
    ///
    /// # Errors
    /// If a value cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String, SettingsError> {
        with_config!(self, config => commented_toml(config))
    }

    /// All parameters, one by one.
    ///
    /// # Errors
    /// As [`Algorithm::to_toml`].
    pub fn parameters(&self) -> Result<Vec<Parameter>, SettingsError> {
        with_config!(self, config => parameters(config))
    }

    /// A localizer that compares what it sees with a model of the world.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn build(self, model: Box<dyn ObservationModel>) -> Result<Box<dyn Localizer>, ConfigError> {
        Ok(match self {
            Self::Evolutionary(config) => Box::new(Evolutionary::new(config, model)?),
            Self::MonteCarlo(config) => Box::new(MonteCarlo::new(config, model)?),
            Self::Markov(config) => Box::new(Markov::new(config, model.as_ref())?),
        })
    }
}

/// An algorithm that can be chosen by name.
#[derive(Debug, Clone, Copy)]
pub struct AlgorithmInfo {
    /// The name.
    pub name: &'static str,
    /// One line about it.
    pub summary: &'static str,
    algorithm: fn() -> Algorithm,
}

/// All algorithms.
pub const ALGORITHMS: [AlgorithmInfo; 9] = [
    AlgorithmInfo {
        name: "evolutionary",
        summary: "races of exploiters around several hypotheses, random explorers (thesis of 2017)",
        algorithm: || Algorithm::Evolutionary(EvolutionaryConfig::default()),
    },
    AlgorithmInfo {
        name: "evolutionary-grid",
        summary: "the same with explorers on a fixed grid (thesis of 2010)",
        algorithm: || {
            let explorers = ExplorerConfig { kind: ExplorerKind::Grid, ..ExplorerConfig::default() };
            Algorithm::Evolutionary(EvolutionaryConfig { explorers, ..EvolutionaryConfig::default() })
        },
    },
    AlgorithmInfo {
        name: "mce",
        summary: "Monte Carlo with elitism: the best particles survive unchanged",
        algorithm: || Algorithm::MonteCarlo(MonteCarloConfig::default()),
    },
    AlgorithmInfo {
        name: "mc",
        summary: "classic Monte Carlo",
        algorithm: || Algorithm::MonteCarlo(MonteCarloConfig::classic()),
    },
    AlgorithmInfo {
        name: "mca",
        summary: "augmented: random particles when the images fit worse than before",
        algorithm: || Algorithm::MonteCarlo(MonteCarloConfig::augmented()),
    },
    AlgorithmInfo {
        name: "mcae",
        summary: "augmented Monte Carlo with elitism",
        algorithm: || Algorithm::MonteCarlo(MonteCarloConfig::augmented_elite()),
    },
    AlgorithmInfo {
        name: "kld",
        summary: "as many particles as needed, and a minimum for each hypothesis",
        algorithm: || Algorithm::MonteCarlo(MonteCarloConfig::kld()),
    },
    AlgorithmInfo {
        name: "mc-systematic",
        summary: "classic Monte Carlo with systematic resampling",
        algorithm: || Algorithm::MonteCarlo(MonteCarloConfig::systematic()),
    },
    AlgorithmInfo {
        name: "markov",
        summary: "belief over a grid of tiles and headings, from goals as a whole; accurate to a tile",
        algorithm: || Algorithm::Markov(MarkovConfig::default()),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_algorithm_lists_the_known_ones() {
        let error = Algorithm::named("kalman").unwrap_err().to_string();
        assert_eq!(
            error,
            "unknown algorithm \"kalman\"; known: evolutionary, evolutionary-grid, mce, mc, mca, mcae, kld, mc-systematic, markov"
        );
    }

    #[test]
    fn a_text_changes_only_what_it_names() {
        let text = "num_particles = 500\n[motion]\nnoise_m_per_m = 0.5\n";
        let changed = Algorithm::named("mc").unwrap().with_toml(text).unwrap();
        let Algorithm::MonteCarlo(config) = changed else { panic!("{changed:?}") };
        assert_eq!(config.num_particles, 500);
        assert!((config.motion.noise_m_per_m - 0.5).abs() < 1e-12);
        assert!(config.elite_share.abs() < 1e-12, "still the classic filter");
    }

    #[test]
    fn unknown_keys_are_refused_with_their_line() {
        let error = Algorithm::named("mc").unwrap().with_toml("\nnum_partikles = 5\n").unwrap_err();
        assert_eq!(error.to_string(), "line 2: unknown key `num_partikles`, did you mean `num_particles`?");
    }

    #[test]
    fn defaults_round_trip() {
        for info in ALGORITHMS {
            let algorithm = Algorithm::named(info.name).unwrap();
            let text = algorithm.to_toml().unwrap();
            assert!(text.contains("[motion]"), "{text}");
            let is_explained = |lines: &[&str]| !lines[1].contains(" = ") || lines[0].starts_with('#');
            let lines: Vec<&str> = text.lines().collect();
            assert!(lines.windows(2).all(is_explained), "{text}");
            assert_eq!(algorithm.with_toml(&text).unwrap(), algorithm);
        }
    }
}
