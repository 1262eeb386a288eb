//! One algorithm with its parameters.

use visloc_core::{Clock, Frame, RngTree, settings::Overrides};

use super::{LineupError, RunSettings};
use crate::{Hypothesis, Pipeline, PosePrior, StartPrior};

/// From this reliability on, what an algorithm knows outlives a change of its parameters.
const WORTH_KEEPING: f64 = 0.3;
/// A pose that is kept is at least so uncertain, meters and radians.
const MIN_SPREAD: (f64, f64) = (0.03, 0.03);
/// Hypotheses that are kept.
const MAX_KEPT: usize = 6;

/// An algorithm that looks for the robot.
#[derive(Debug)]
pub struct Contender {
    name: String,
    overrides: Overrides,
    pipeline: Pipeline,
}

impl Contender {
    /// An algorithm that knows nothing but what the settings say about the start.
    ///
    /// # Errors
    /// If there is no such algorithm, or a parameter is wrong.
    pub fn new(
        name: &str,
        overrides: Overrides,
        settings: &RunSettings,
        clock: &Clock,
    ) -> Result<Self, LineupError> {
        let toml = overrides.toml()?;
        let pipeline = Pipeline::builder(&settings.map)
            .named(name, Some(&toml))
            .config(settings.pipeline)
            .rng(RngTree::new(settings.seed).subtree("pipeline", 0))
            .start(settings.start.clone())
            .clock(clock.clone())
            .build()?;
        Ok(Self { name: name.to_owned(), overrides, pipeline })
    }

    /// The same algorithm with other parameters. It begins where this one believes to be, if that is worth something.
    ///
    /// # Errors
    /// As [`Contender::new`].
    pub fn changed(
        &self,
        overrides: Overrides,
        settings: &RunSettings,
        clock: &Clock,
    ) -> Result<Self, LineupError> {
        let mut changed = Self::new(&self.name, overrides, settings, clock)?;
        changed.pipeline.reset_to(&self.knowledge());
        Ok(changed)
    }

    fn knowledge(&self) -> StartPrior {
        let estimate = self.pipeline.estimate();
        if estimate.reliability_up_to_symmetry < WORTH_KEEPING {
            return StartPrior::Uniform;
        }
        let prior = |hypothesis: &Hypothesis| {
            let spread = |i: usize| hypothesis.covariance[(i, i)].max(0.0).sqrt();
            PosePrior {
                world_from_robot: hypothesis.world_from_robot,
                position_spread_m: spread(0).hypot(spread(1)).max(MIN_SPREAD.0),
                heading_spread_rad: spread(2).max(MIN_SPREAD.1),
                weight: hypothesis.probability,
            }
        };
        let priors: Vec<_> = estimate.hypotheses.iter().take(MAX_KEPT).map(prior).collect();
        if priors.is_empty() { StartPrior::Uniform } else { StartPrior::Poses(priors) }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What is different from its defaults.
    pub fn overrides(&self) -> &Overrides {
        &self.overrides
    }

    /// Image analysis and localizer.
    pub fn pipeline(&self) -> &Pipeline {
        &self.pipeline
    }

    /// Takes in a frame.
    ///
    /// # Errors
    /// If the image does not belong to its camera; the frame can be left out and the run go on.
    pub fn step(&mut self, frame: &Frame) -> Result<(), LineupError> {
        self.pipeline.step(frame)?;
        Ok(())
    }

    /// Begins again with what is known about the pose.
    pub fn reset_to(&mut self, prior: &StartPrior) {
        self.pipeline.reset_to(prior);
    }
}
