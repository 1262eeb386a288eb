//! Algorithms side by side, whose parameters people may change while they run.
//!
//! [`RunSettings`] is everything that decides about a run besides its input, [`Contender`] one algorithm, [`Lineup`] all of them.

mod contender;
mod error;
mod side_by_side;

use std::sync::Arc;

pub use contender::Contender;
pub use error::LineupError;
pub use side_by_side::{Lineup, MAX_ALGORITHMS};
use visloc_core::settings::{Overrides, overlay, parameters};
use visloc_world::Map;

use crate::{PipelineConfig, StartPrior};

/// What an algorithm is run with. The same settings and the same frames give the same estimates, bit by bit.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    /// The map, which what is shown shares.
    pub map: Arc<Map>,
    /// Seed of everything random.
    pub seed: u64,
    /// What is known about the start.
    pub start: StartPrior,
    /// Parameters of everything but the algorithms.
    pub pipeline: PipelineConfig,
    /// Names of the algorithms, and what is different from their defaults.
    pub algorithms: Vec<(String, Overrides)>,
}

impl RunSettings {
    /// Parameters of everything but the algorithms that are not as by default.
    ///
    /// # Errors
    /// If the parameters cannot be written.
    pub fn pipeline_overrides(&self) -> Result<Overrides, LineupError> {
        let defaults = parameters(&PipelineConfig::default())?;
        Ok(Overrides::between(&defaults, parameters(&self.pipeline)?))
    }

    /// The same with other parameters of everything but the algorithms.
    ///
    /// # Errors
    /// If a parameter is unknown or out of its range.
    pub fn with_pipeline(&self, overrides: &Overrides) -> Result<Self, LineupError> {
        let pipeline = overlay(&PipelineConfig::default(), &overrides.toml()?)
            .map_err(|error| LineupError::refused("parameter", "a possible value", error.reason))?;
        Ok(Self { pipeline, ..self.clone() })
    }
}
