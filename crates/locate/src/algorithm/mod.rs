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
    use serde_json::Value;

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
            let is_value = |line: &str| line.contains(" = ") && !line.starts_with('#');
            let is_explained = |lines: &[&str]| !is_value(lines[1]) || lines[0].starts_with('#');
            let lines: Vec<&str> = text.lines().collect();
            assert!(lines.windows(2).all(is_explained), "{text}");
            assert_eq!(algorithm.with_toml(&text).unwrap(), algorithm);
        }
    }

    /// A switch of a condition such as `kind = grid` or `growth > 0`, on or off, as TOML.
    fn switch(all: &[Parameter], parameter: &Parameter, is_on: bool) -> String {
        let condition = parameter.only_if.as_deref().unwrap();
        let (key, _, wanted) = {
            let mut words = condition.splitn(3, ' ');
            (words.next().unwrap(), words.next().unwrap(), words.next().unwrap())
        };
        let table = parameter.path.rsplit_once('.').map_or("", |(table, _)| table);
        let path = format!("{table}.{key}");
        let path = path.trim_start_matches('.');
        let other = all.iter().find(|other| other.path == path).unwrap_or_else(|| panic!("{path} is no key"));
        let value = match (&other.value, is_on) {
            (Value::Bool(_), _) => format!("{is_on}"),
            (Value::Number(number), true) if number.is_u64() => "1".to_owned(),
            (Value::Number(number), false) if number.is_u64() => "0".to_owned(),
            (Value::Number(_), true) => "0.5".to_owned(),
            (Value::Number(_), false) => "0.0".to_owned(),
            (_, true) => format!("{wanted:?}"),
            (_, false) => {
                let others = other.choices.iter().find(|choice| choice.name != wanted);
                format!("{:?}", others.unwrap().name)
            }
        };
        format!("{path} = {value}\n")
    }

    /// A value that differs a little.
    fn changed(parameter: &Parameter) -> String {
        match &parameter.value {
            Value::Bool(is) => format!("{}", !is),
            Value::Number(number) => match number.as_u64() {
                Some(whole) => format!("{}", whole + 1),
                None => format!("{}", number.as_f64().unwrap() * 0.97 + 0.0011),
            },
            Value::String(name) => {
                format!("{:?}", parameter.choices.iter().find(|choice| choice.name != *name).unwrap().name)
            }
            other => panic!("{other}"),
        }
    }

    /// What counts only beside another value is refused without it, and taken with it.
    #[test]
    fn no_parameter_is_taken_and_counts_for_nothing() {
        let mut num_conditions = 0;
        for info in ALGORITHMS {
            let algorithm = Algorithm::named(info.name).unwrap();
            let all = algorithm.parameters().unwrap();
            for parameter in all.iter().filter(|parameter| parameter.only_if.is_some()) {
                num_conditions += 1;
                let text = format!("{} = {}\n", parameter.path, changed(parameter));
                let with = |is_on| algorithm.with_toml(&(text.clone() + &switch(&all, parameter, is_on)));
                let error = with(false).unwrap_err().to_string();
                let (path, condition) = (&parameter.path, parameter.only_if.as_deref().unwrap());
                let expected =
                    format!("line 1: {path}: it would change nothing: it counts only with {condition}");
                assert_eq!(error, expected, "{}", info.name);
                assert_ne!(with(true).unwrap_or_else(|error| panic!("{path}: {error}")), algorithm);
            }
        }
        assert!(num_conditions > 100, "{num_conditions}");
    }
}
