//! Settings of a pipeline before it is built.

use visloc_core::{Clock, RngTree};
use visloc_world::Map;

use super::{Pipeline, PipelineConfig, algorithm_on};
use crate::{Algorithm, ConfigError, StartPrior};

/// Settings of a [`Pipeline`].
#[derive(Debug)]
pub struct PipelineBuilder<'a> {
    map: &'a Map,
    algorithm: Choice<'a>,
    config: PipelineConfig,
    rng: RngTree,
    start: StartPrior,
    clock: Clock,
}

/// How the algorithm was chosen.
#[derive(Debug)]
enum Choice<'a> {
    Named { name: &'a str, toml: Option<&'a str> },
    Made(Box<Algorithm>),
}

impl<'a> PipelineBuilder<'a> {
    pub(crate) fn new(map: &'a Map) -> Self {
        Self {
            map,
            algorithm: Choice::Named { name: "evolutionary", toml: None },
            config: PipelineConfig::default(),
            rng: RngTree::new(1),
            start: StartPrior::Uniform,
            clock: Clock::still(),
        }
    }

    /// The algorithm, with exactly these parameters. [`Algorithm::on_map`] gives those that suit a map.
    #[must_use]
    pub fn algorithm(self, algorithm: Algorithm) -> Self {
        Self { algorithm: Choice::Made(Box::new(algorithm)), ..self }
    }

    /// The algorithm of a name ([`ALGORITHMS`](crate::ALGORITHMS)) with the parameters that suit the map, and those that a text of TOML
    /// overrides.
    #[must_use]
    pub fn named(self, name: &'a str, toml: Option<&'a str>) -> Self {
        Self { algorithm: Choice::Named { name, toml }, ..self }
    }

    /// Parameters of everything but the algorithm.
    #[must_use]
    pub fn config(self, config: PipelineConfig) -> Self {
        Self { config, ..self }
    }

    /// What is known about the pose at the start; by default nothing.
    #[must_use]
    pub fn start(self, start: StartPrior) -> Self {
        Self { start, ..self }
    }

    /// Seed of everything random: the same frames and seed give the same estimates, bit by bit.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        self.rng(RngTree::new(seed))
    }

    /// Random streams, in place of a seed.
    #[must_use]
    pub fn rng(self, rng: RngTree) -> Self {
        Self { rng, ..self }
    }

    /// A clock to measure steps with; never used for a result.
    #[must_use]
    pub fn clock(self, clock: Clock) -> Self {
        Self { clock, ..self }
    }

    /// Builds the pipeline.
    ///
    /// # Errors
    /// If there is no such algorithm or a parameter is unknown or out of its range.
    pub fn build(self) -> Result<Pipeline, ConfigError> {
        let algorithm = match self.algorithm {
            Choice::Made(algorithm) => *algorithm,
            Choice::Named { name, toml } => algorithm_on(self.map, name, self.config.features, toml)?,
        };
        let mut pipeline = Pipeline::new(self.map, algorithm, &self.config, self.rng, self.clock)?;
        if !self.start.is_uniform() {
            pipeline.reset_to(&self.start);
        }
        Ok(pipeline)
    }
}
