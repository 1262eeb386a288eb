//! Settings of a pipeline before it is built.

use std::fmt;

use visloc_core::{Clock, RngTree};
use visloc_world::Map;

use super::{Pipeline, PipelineConfig, algorithm_on};
use crate::{Algorithm, ConfigError, Localizer, ObservationModel, StartPrior};

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
enum Choice<'a> {
    Named { name: &'a str, toml: Option<&'a str> },
    Made(Box<Algorithm>),
    Own(OwnLocalizer<'a>),
}

impl fmt::Debug for Choice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named { name, toml } => {
                f.debug_struct("Named").field("name", name).field("toml", toml).finish()
            }
            Self::Made(algorithm) => f.debug_tuple("Made").field(algorithm).finish(),
            Self::Own(_) => f.debug_tuple("Own").finish_non_exhaustive(),
        }
    }
}

type OwnLocalizer<'a> = Box<dyn FnOnce(Box<dyn ObservationModel>) -> Box<dyn Localizer> + 'a>;

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

    /// An algorithm of one's own. It is given what weighs poses against the images on this map; as those of visloc it is refined by all
    /// borders in view unless the [features](PipelineConfig::features) are single pixels.
    #[must_use]
    pub fn localizer<L: Localizer + 'static>(
        self,
        localizer_for: impl FnOnce(Box<dyn ObservationModel>) -> L + 'a,
    ) -> Self {
        Self { algorithm: Choice::Own(Box::new(|model| Box::new(localizer_for(model)))), ..self }
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
    /// If there is no such algorithm, a parameter is unknown or out of its range, or [`StartPrior::check`] refuses the start.
    pub fn build(self) -> Result<Pipeline, ConfigError> {
        let Self { map, algorithm, config, rng, start, clock } = self;
        start.check()?;
        let localizer_for = |model: Box<dyn ObservationModel>| match algorithm {
            Choice::Made(algorithm) => algorithm.build(model),
            Choice::Named { name, toml } => algorithm_on(map, name, config.features, toml)?.build(model),
            Choice::Own(localizer_for) => Ok(localizer_for(model)),
        };
        let mut pipeline = Pipeline::new(map, localizer_for, &config, rng, clock)?;
        if !start.is_uniform() {
            pipeline.reset_to(&start);
        }
        Ok(pipeline)
    }
}
