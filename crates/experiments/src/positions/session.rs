//! A localizer in the synthetic world.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use visloc_core::{Rng, Timestamp, geom::PlanarPose};
use visloc_locate::{
    Algorithm, ConfigError, Individual, Localizer, ObservationModel as _, StepInput, vision::Percept,
};

use super::{Census, NEAR_M, PositionsWorld, Scenario, UniformControl};

/// An algorithm with its parameters.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contender {
    /// In tables.
    pub label: String,
    /// Name of the algorithm; `uniform` is the null control.
    pub algorithm: String,
    /// Parameters that differ from the algorithm's defaults, TOML.
    pub config: String,
    /// How many individuals it has in all: particles, or exploiters and explorers.
    pub num_individuals: usize,
}

/// One run of a contender, iteration by iteration.
pub struct Session {
    scenario: Arc<Scenario>,
    localizer: Box<dyn Localizer>,
    percept: Percept,
    iteration: usize,
    individuals: Vec<Individual>,
}

impl Session {
    /// A session before its first iteration.
    ///
    /// # Errors
    /// If there is no such algorithm or a parameter is unknown or out of its range.
    pub fn new(contender: &Contender, scenario: Arc<Scenario>, floor: f64) -> Result<Self, ConfigError> {
        let world = PositionsWorld::new(Arc::clone(&scenario), floor);
        let localizer: Box<dyn Localizer> = if contender.algorithm == "uniform" {
            Box::new(UniformControl::new(world.region(), contender.num_individuals))
        } else {
            let algorithm = Algorithm::named(&contender.algorithm)?.with_toml(&contender.config);
            let mistake = |error| ConfigError::from_settings(&contender.algorithm, error);
            algorithm.map_err(mistake)?.build(Box::new(world))?
        };
        // The picture is empty but says something: the world's likelihood needs no pixels.
        let percept = Percept { quality: 1.0, is_informative: true, ..Percept::default() };
        Ok(Self { scenario, localizer, percept, iteration: 0, individuals: Vec::new() })
    }

    /// The next iteration. The robot's odometry stands still; only positions move.
    pub fn step(&mut self, rng: &mut Rng) {
        self.percept.at = Timestamp::from_secs(self.iteration as f64);
        let odometry = Some(PlanarPose::default());
        let input = StepInput { percept: &self.percept, odometry, is_lifted: false };
        self.localizer.step(&input, rng);
        self.iteration += 1;
    }

    /// How many iterations are done.
    pub fn num_done(&self) -> usize {
        self.iteration
    }

    /// Positions of the last iteration.
    pub fn positions(&self) -> &[[f64; 2]] {
        self.scenario.positions(self.iteration.saturating_sub(1))
    }

    /// Counts the individuals near each position of the last iteration.
    pub fn count(&mut self, census: &mut Census) {
        self.individuals.clear();
        self.localizer.individuals(&mut self.individuals);
        census.count(self.scenario.positions(self.iteration.saturating_sub(1)), &self.individuals);
    }

    /// All individuals after the last iteration.
    pub fn individuals(&mut self) -> &[Individual] {
        self.individuals.clear();
        self.localizer.individuals(&mut self.individuals);
        &self.individuals
    }

    /// Whether the localizer's answer is near one of the positions of the last iteration.
    pub fn is_answer_near(&self) -> bool {
        let answer = self.localizer.estimate().world_from_robot;
        self.positions().iter().any(|p| (p[0] - answer.x_m).hypot(p[1] - answer.y_m) <= NEAR_M)
    }
}
