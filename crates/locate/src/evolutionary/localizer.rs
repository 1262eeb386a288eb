//! The algorithm, one iteration a frame.

use visloc_base::Rng;
use visloc_geom::PlanarPose;

use super::{
    EvolutionaryConfig,
    explorers::Explorers,
    race::Exploiter,
    races::{Races, WinnerChange},
};
use crate::{
    ConfigError, Estimate, Hypothesis, Individual, Localizer, MotionModel, ObservationModel, Reliability,
    StepInput,
};

/// Evolutionary localization with races, explorers and exploiters.
pub struct Evolutionary {
    config: EvolutionaryConfig,
    model: Box<dyn ObservationModel>,
    motion: MotionModel,
    reliability: Reliability,
    explorers: Explorers,
    races: Races,
    parents: Vec<Exploiter>,
    estimate: Estimate,
}

impl Evolutionary {
    /// A localizer that does not know where it is.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(config: EvolutionaryConfig, model: Box<dyn ObservationModel>) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            motion: MotionModel::new(config.motion),
            reliability: Reliability::new(config.reliability),
            explorers: Explorers::new(config.explorers, config.min_health),
            races: Races::default(),
            parents: Vec::with_capacity(config.num_exploiters),
            estimate: Estimate::unknown(),
            config,
            model,
        })
    }

    /// Moves everything with the robot.
    fn apply_motion(&mut self, odometry: Option<PlanarPose>, rng: &mut Rng) {
        let Some(motion) = self.motion.update(odometry) else { return };
        self.explorers.apply_motion(&motion);
        for race in self.races.iter_mut() {
            race.apply_motion(&motion, &self.config, rng);
        }
        self.estimate.world_from_robot = motion.apply(&self.estimate.world_from_robot);
        for hypothesis in &mut self.estimate.hypotheses {
            hypothesis.world_from_robot = motion.apply(&hypothesis.world_from_robot);
        }
    }

    /// Lets explorers search, and makes races of what they find.
    fn explore(&mut self, is_informative: bool, rng: &mut Rng) {
        // Until the first good answer the search is as deep as when the robot is lost.
        let is_lost = !self.estimate.is_localized() || self.races.all_below(self.config.lost_health);
        let found = self.explorers.search(self.model.as_ref(), is_informative, is_lost, rng);
        if let Some(candidates) = found {
            self.races.offer(candidates, &self.config, rng);
        }
    }

    /// Follows the winner's health, and loses trust when the answer jumps.
    fn update_reliability(&mut self, change: Option<WinnerChange>, quality: f64) {
        let Some(winner) = self.races.winner() else {
            self.reliability.reset();
            return;
        };
        self.reliability.update(winner.last_health, quality);
        match change {
            Some(WinnerChange { distance_m: Some(distance_m) }) => {
                self.reliability.jump(distance_m, self.model.max_jump_m());
            }
            Some(WinnerChange { distance_m: None }) => self.reliability.reset(),
            None => {}
        }
    }

    fn update_estimate(&mut self) {
        let estimate = &mut self.estimate;
        estimate.reliability = self.reliability.value();
        estimate.hypotheses.clear();
        let Some(winner) = self.races.winner() else { return };
        estimate.world_from_robot = winner.pose;
        estimate.covariance = winner.covariance;
        estimate.likelihood = winner.last_health;
        for race in self.races.iter() {
            let weight = self.config.weight(race.health) * f64::from(race.victories + 1);
            estimate.hypotheses.push(Hypothesis {
                world_from_robot: race.pose,
                covariance: race.covariance,
                probability: weight,
            });
        }
        estimate.normalize_hypotheses();
    }
}

impl Localizer for Evolutionary {
    fn reset(&mut self) {
        self.races.clear();
        self.explorers.reset();
        self.reliability.reset();
        self.estimate.reliability = 0.0;
        self.estimate.hypotheses.clear();
    }

    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        if input.is_lifted {
            self.motion.update(input.odometry);
            self.reset();
            return &self.estimate;
        }
        self.apply_motion(input.odometry, rng);
        self.model.condition_on(input.percept);
        if !self.model.has_evidence() {
            return &self.estimate;
        }
        for race in self.races.iter_mut() {
            race.weigh(self.model.as_ref(), &self.config);
        }
        self.explore(input.percept.is_informative, rng);
        self.races.merge(&self.config);
        self.races.age(&self.config);
        let reliability = self.reliability.value();
        let change = self.races.choose_winner(&self.config, reliability, input.percept.is_informative);
        self.update_reliability(change, input.percept.quality);
        self.update_estimate();
        self.races.evolve(&self.config, rng, &mut self.parents);
        debug_assert!(self.races.winner().is_some() || self.races.is_empty());
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    fn individuals(&self, out: &mut Vec<Individual>) {
        for (population, race) in self.races.iter().enumerate() {
            out.extend(race.exploiters.iter().map(|exploiter| Individual {
                world_from_robot: exploiter.pose,
                likelihood: exploiter.health,
                population,
            }));
        }
    }
}
