//! The algorithm, one iteration a frame.

use visloc_core::{Rng, Timestamp, geom::PlanarPose};

use super::{
    EvolutionaryConfig,
    explorers::{Explorers, keep_best},
    race::Exploiter,
    races::{Races, WinnerChange},
};
use crate::{
    ConfigError, Estimate, Hypothesis, Individual, LOCALIZED_RELIABILITY, Localizer, MotionModel,
    ObservationModel, PlanarMotion, Reliability, StartPrior, StepInput,
};

/// Poses taken from a prior to found races from the best of them.
const PRIOR_POSES: usize = 200;

/// Evolutionary localization with races, explorers and exploiters.
pub struct Evolutionary {
    config: EvolutionaryConfig,
    model: Box<dyn ObservationModel>,
    motion: MotionModel,
    reliability: Reliability,
    explorers: Explorers,
    races: Races,
    parents: Vec<Exploiter>,
    /// What is known about the start, until races were founded from it.
    prior: StartPrior,
    /// Where the robot was before it was lifted.
    old_pose: Option<PlanarPose>,
    /// Somebody says that the answer is wrong.
    is_doubted: bool,
    estimate: Estimate,
}

visloc_core::debug_shows!([] Evolutionary { config, estimate });

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
            prior: StartPrior::Uniform,
            old_pose: None,
            is_doubted: false,
            estimate: Estimate::unknown(),
            config,
            model,
        })
    }

    /// Moves explorers and races with the robot.
    fn apply_motion(
        &mut self,
        at: Timestamp,
        odometry: Option<PlanarPose>,
        rng: &mut Rng,
    ) -> Option<PlanarMotion> {
        let motion = self.motion.update(at, odometry)?;
        self.explorers.apply_motion(&motion);
        for race in self.races.iter_mut() {
            race.apply_motion(&motion, &self.config, rng);
        }
        Some(motion)
    }

    /// The image says nothing: the pose is followed by the motion alone, and trusted less and less.
    fn go_blind(&mut self, motion: Option<&PlanarMotion>) {
        let secs = self.motion.secs();
        let more_m = self.estimate.go_blind(motion, secs, &self.config.motion);
        self.reliability.fade(secs);
        self.reliability.jump(more_m, self.model.max_jump_m());
        self.trust();
    }

    /// Begins again with a prior, and remembers where the robot was if that is wished for.
    fn begin_again(&mut self, prior: StartPrior) {
        if self.config.keeps_old_pose && self.estimate.is_localized() {
            self.old_pose = Some(self.estimate.world_from_robot);
        }
        self.prior = prior;
        self.races.clear();
        self.explorers.reset();
        self.reliability.reset();
        self.estimate.forget();
    }

    /// Founds races from what is known about the start. Explorers search beside them, everywhere.
    fn found_races(&mut self, rng: &mut Rng) {
        let (prior, model) = (std::mem::take(&mut self.prior), self.model.as_ref());
        let region = model.region();
        let mut founders = Vec::new();
        let with_health = |pose| Exploiter { pose, health: model.likelihood(&pose) };
        if let Some(old_pose) = self.old_pose.take().filter(|pose| region.contains(pose)) {
            self.races.offer(&[with_health(old_pose)], &self.config, rng);
        }
        if prior.is_uniform() {
            return;
        }
        for _ in 0..PRIOR_POSES {
            let mut pose = prior.sample(&region, rng);
            if !prior.has_heading() {
                pose.yaw_rad = model.propose_heading(pose.x_m, pose.y_m, rng);
            }
            keep_best(&mut founders, with_health(pose), self.config.max_races);
        }
        self.races.offer(&founders, &self.config, rng);
    }

    /// Lets explorers search, and makes races of what they find.
    fn explore(&mut self, is_informative: bool, rng: &mut Rng) {
        // Until the first good answer the search is as deep as when the robot is lost.
        let is_doubted = std::mem::take(&mut self.is_doubted);
        let is_lost = is_doubted
            || self.reliability.value() <= LOCALIZED_RELIABILITY
            || self.races.all_below(self.config.lost_health);
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
        self.reliability.update(winner.last_health, quality, self.motion.secs());
        match change {
            Some(WinnerChange { distance_m: Some(distance_m) }) => {
                self.reliability.jump(distance_m, self.model.max_jump_m());
            }
            Some(WinnerChange { distance_m: None }) => self.reliability.reset(),
            None => {}
        }
    }

    fn trust(&mut self) {
        self.estimate.set_reliability(self.reliability.value() * self.races.undisputed(&self.config));
        self.races.set_trust(self.estimate.reliability);
    }

    fn update_estimate(&mut self) {
        self.trust();
        let estimate = &mut self.estimate;
        estimate.hypotheses.clear();
        let Some(winner) = self.races.winner() else { return };
        estimate.world_from_robot = winner.pose;
        estimate.covariance = winner.covariance;
        estimate.likelihood = winner.last_health;
        for race in self.races.iter() {
            let weight = if self.config.evidence.is_on() {
                race.evidence.exp()
            } else {
                self.config.weight(race.health) * f64::from(race.victories + 1)
            };
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
        self.begin_again(StartPrior::Uniform);
        self.old_pose = None;
    }

    fn reset_to(&mut self, prior: &StartPrior) {
        self.begin_again(prior.clone());
    }

    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        if input.is_lifted {
            self.motion.update(input.percept.at, input.odometry);
            self.begin_again(StartPrior::Uniform);
            return &self.estimate;
        }
        let motion = self.apply_motion(input.percept.at, input.odometry, rng);
        self.model.condition_on(input.percept);
        if !self.model.has_evidence() {
            self.go_blind(motion.as_ref());
            return &self.estimate;
        }
        if let Some(motion) = motion {
            self.estimate.move_by(&motion);
        }
        self.motion.note_evidence();
        for race in self.races.iter_mut() {
            race.weigh(self.model.as_ref(), &self.config);
        }
        self.found_races(rng);
        self.explore(input.percept.is_informative, rng);
        self.races.compete(&self.config);
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

    fn doubt(&mut self) {
        self.is_doubted = true;
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

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;
    use crate::{PosePrior, Region, vision::Percept};

    /// Two places that look alike, at x = -3 and x = 3.
    struct TwoPlaces;

    impl ObservationModel for TwoPlaces {
        fn condition_on(&mut self, _: &Percept) {}
        fn has_evidence(&self) -> bool {
            true
        }
        fn likelihood(&self, pose: &PlanarPose) -> f64 {
            (-0.5 * ((pose.x_m.abs() - 3.0).powi(2) + pose.y_m.powi(2) + pose.yaw_rad.powi(2))).exp()
        }
        fn region(&self) -> Region {
            Region { min_x_m: -5.0, max_x_m: 5.0, min_y_m: -4.0, max_y_m: 4.0 }
        }
        fn max_jump_m(&self) -> f64 {
            2.0
        }
        fn propose(&self, rng: &mut Rng) -> PlanarPose {
            self.region().sample(rng)
        }
        fn propose_heading(&self, _: f64, _: f64, _: &mut Rng) -> f64 {
            0.0
        }
    }

    fn steps(localizer: &mut Evolutionary, percept: &Percept, count: usize, is_lifted: bool) {
        let mut rng = RngTree::new(3).stream("evolutionary", 0);
        for _ in 0..count {
            localizer.step(&StepInput { percept, odometry: None, is_lifted }, &mut rng);
        }
    }

    fn places(localizer: &Evolutionary) -> Vec<f64> {
        localizer.estimate().hypotheses.iter().map(|h| h.world_from_robot.x_m.round()).collect()
    }

    #[test]
    fn races_are_founded_from_the_prior() {
        let mut localizer = Evolutionary::new(EvolutionaryConfig::default(), Box::new(TwoPlaces)).unwrap();
        // Without something informative in view explorers do not search.
        let percept = Percept { quality: 1.0, ..Percept::default() };
        steps(&mut localizer, &percept, 5, false);
        assert!(places(&localizer).is_empty());
        let prior = PosePrior {
            world_from_robot: PlanarPose::new(3.0, 0.2, 0.1),
            position_spread_m: 0.2,
            heading_spread_rad: 0.1,
            weight: 1.0,
        };
        localizer.reset_to(&StartPrior::Poses(vec![prior]));
        steps(&mut localizer, &percept, 20, false);
        assert_eq!(places(&localizer), [3.0]);
        let region = Region { min_x_m: -5.0, max_x_m: -1.0, min_y_m: -4.0, max_y_m: 4.0 };
        localizer.reset_to(&StartPrior::Region { region, heading: None });
        steps(&mut localizer, &percept, 20, false);
        assert!(places(&localizer).iter().all(|x| *x < 0.0) && !places(&localizer).is_empty());
    }

    #[test]
    fn the_old_pose_is_kept_after_a_lift_if_wished_for() {
        for keeps_old_pose in [true, false] {
            let config = EvolutionaryConfig { keeps_old_pose, ..EvolutionaryConfig::default() };
            let mut localizer = Evolutionary::new(config, Box::new(TwoPlaces)).unwrap();
            let informative = Percept { quality: 1.0, is_informative: true, ..Percept::default() };
            steps(&mut localizer, &informative, 60, false);
            assert!(localizer.estimate().is_localized());
            let before = localizer.estimate().world_from_robot.x_m.round();
            let percept = Percept { quality: 1.0, ..Percept::default() };
            steps(&mut localizer, &percept, 3, true);
            assert!(places(&localizer).is_empty());
            steps(&mut localizer, &percept, 3, false);
            let expected: &[f64] = if keeps_old_pose { &[before] } else { &[] };
            assert_eq!(places(&localizer), expected);
        }
    }
}
