//! The particle filter: motion, weights, estimate, survivors.

use rand::RngExt;
use visloc_core::{Rng, Timestamp, gaussian, geom::PlanarPose};

use super::{
    MonteCarloConfig, Particles, PoseNoise,
    estimator::Estimator,
    recovery::Recovery,
    survivors::{Survivors, Weighed},
};
use crate::{
    ConfigError, Estimate, Individual, Localizer, MotionModel, ObservationModel, PlanarMotion, Reliability,
    StartPrior, StepInput,
};

/// A particle filter over planar poses.
pub struct MonteCarlo {
    config: MonteCarloConfig,
    model: Box<dyn ObservationModel>,
    motion: MotionModel,
    reliability: Reliability,
    particles: Particles,
    /// Noise of the survivors, which they get with the next motion.
    noise: PoseNoise,
    recovery: Recovery,
    prior: StartPrior,
    /// Where the robot was before it was lifted.
    old_pose: Option<PlanarPose>,
    /// Images since the start was wished for.
    waited: u32,
    /// Images in a row that no particle explained.
    unexplained: u32,
    /// Particles that the last step weighed; the number of survivors may differ.
    num_weighed: usize,
    /// The best particles, in order.
    best: Vec<usize>,
    survivors: Survivors,
    estimator: Estimator,
    estimate: Estimate,
}

visloc_core::debug_shows!([] MonteCarlo { config, estimate });

impl MonteCarlo {
    /// A filter that does not know where it is.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(config: MonteCarloConfig, model: Box<dyn ObservationModel>) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            motion: MotionModel::new(config.motion),
            reliability: Reliability::new(config.reliability),
            config,
            model,
            particles: Particles::default(),
            noise: PoseNoise::default(),
            recovery: Recovery::default(),
            prior: StartPrior::Uniform,
            old_pose: None,
            waited: 0,
            unexplained: 0,
            num_weighed: 0,
            best: Vec::new(),
            survivors: Survivors::default(),
            estimator: Estimator::default(),
            estimate: Estimate::unknown(),
        })
    }

    /// The particles.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// Begins again with a prior, and remembers where the robot was if that is wished for.
    fn begin_again(&mut self, prior: StartPrior) {
        if self.estimate.is_localized() {
            self.old_pose = Some(self.estimate.world_from_robot);
        }
        self.prior = prior;
        self.particles.clear();
        self.noise = PoseNoise::default();
        self.recovery = Recovery::default();
        self.waited = 0;
        self.unexplained = 0;
        self.reliability.reset();
        self.estimate.forget();
    }

    /// Particles from the prior, some of them aimed at what is seen, some where the robot was before.
    fn start(&mut self, rng: &mut Rng) {
        let (begin, count) = (&self.config.initialization, self.config.num_particles);
        let (model, prior, region) = (self.model.as_ref(), &self.prior, self.model.region());
        let old_pose = self.old_pose.take();
        let num_old = if old_pose.is_some() { share(begin.keep_old_pose_share, count) } else { 0 };
        let old_pose = old_pose.unwrap_or_default();
        let poses = (0..count).map(|i| {
            if i < num_old {
                let (noise_m, noise_rad) = (begin.old_pose_noise_m, begin.old_pose_noise_rad);
                return PlanarPose::new(
                    old_pose.x_m + gaussian(rng, noise_m),
                    old_pose.y_m + gaussian(rng, noise_m),
                    old_pose.yaw_rad + gaussian(rng, noise_rad),
                );
            }
            let is_aimed = !prior.has_heading() && rng.random_bool(begin.aimed_share);
            if is_aimed && prior.is_uniform() {
                return model.propose(rng);
            }
            let mut pose = if prior.is_uniform() { model.sample(rng) } else { prior.sample(&region, rng) };
            if is_aimed {
                pose.yaw_rad = model.propose_heading(pose.x_m, pose.y_m, rng);
            }
            pose
        });
        self.particles.start(poses);
        self.noise = PoseNoise::default();
        self.recovery = Recovery::default();
        self.unexplained = 0;
        self.reliability.reset();
    }

    /// Moves the particles with the robot. Survivors get their noise on this occasion.
    fn propagate(
        &mut self,
        at: Timestamp,
        odometry: Option<PlanarPose>,
        rng: &mut Rng,
    ) -> Option<PlanarMotion> {
        let motion = self.motion.update(at, odometry);
        let noise = std::mem::take(&mut self.noise);
        self.particles.propagate(motion.as_ref(), &noise, rng);
        motion
    }

    #[cfg(test)]
    pub(super) fn propagate_for_test(&mut self, odometry: Option<PlanarPose>, rng: &mut Rng) {
        self.propagate(Timestamp::default(), odometry, rng);
    }

    /// The image says nothing: the pose is followed by the motion alone, and trusted less and less.
    fn go_blind(&mut self, motion: Option<&PlanarMotion>) {
        let secs = self.motion.secs();
        let more_m = self.estimate.go_blind(motion, secs, &self.config.motion);
        self.reliability.fade(secs);
        self.reliability.jump(more_m, self.model.max_jump_m());
        self.estimate.set_reliability(self.reliability.value());
    }

    fn weigh(&mut self) {
        let config = &self.config;
        self.particles.weigh(self.model.as_ref(), config.weight_exponent, config.parallel_from);
        let count = self.particles.len();
        self.num_weighed = count;
        let num_best = config.estimate.num_best(count).max(share(config.elite_share, config.num_particles));
        self.particles.rank(num_best, &mut self.best);
    }

    /// Whether no particle has explained the images for too long.
    fn must_restart(&mut self) -> bool {
        let restart = &self.config.restart;
        let best = self.particles.likelihoods().iter().copied().fold(0.0, f64::max);
        self.unexplained = if best < restart.min_likelihood { self.unexplained + 1 } else { 0 };
        self.unexplained >= restart.after
    }

    fn update_estimate(&mut self, quality: f64) {
        let config = (&self.config.estimate, &self.config.clusters);
        self.estimator.update(config, &self.particles, &self.best, &mut self.estimate);
        self.reliability.update(self.estimate.likelihood, quality, self.motion.secs());
        self.estimate.set_reliability(self.reliability.value());
    }

    /// The elite unchanged, copies drawn by weight, and newcomers.
    fn resample(&mut self, rng: &mut Rng) {
        let config = &self.config;
        let clusters = &self.estimator.clusters;
        let mean = self.particles.mean_likelihood(!config.injection.is_mean_of_survivors);
        let newcomer_share = self.recovery.update(mean, &config.injection);
        let misfit = (config.noise.fit_likelihood - self.estimate.likelihood).max(0.0);
        let growth = 1.0 + config.noise.growth * misfit * 10.0;
        self.noise = PoseNoise {
            position_m: config.noise.position_m * growth,
            heading_rad: config.noise.heading_rad * growth,
        };
        let is_due = share(newcomer_share, self.particles.len()) > 0
            || config.resampling.is_due(self.particles.effective_share());
        if !is_due {
            let num_elite = share(config.elite_share, self.particles.len());
            self.survivors.keep(&self.particles, &self.best, num_elite);
            self.particles.replace(&self.survivors.sources, &self.survivors.logs, num_elite, []);
            return;
        }
        let weighed = Weighed { particles: &self.particles, clusters, best: &self.best };
        let makeup = self.survivors.makeup(config, weighed, newcomer_share, rng);
        self.survivors.draw(config, weighed, &makeup, rng);
        let (model, source) = (self.model.as_ref(), config.injection.source);
        let newcomers = (0..makeup.num_newcomers).map(|_| source.sample(model, rng));
        self.particles.replace(&self.survivors.sources, &self.survivors.logs, makeup.num_elite, newcomers);
    }
}

/// A share of a number, rounded.
pub(crate) fn share(share: f64, of: usize) -> usize {
    (share * of as f64).round() as usize
}

impl Localizer for MonteCarlo {
    fn reset(&mut self) {
        self.begin_again(StartPrior::Uniform);
        self.old_pose = None;
    }

    fn reset_to(&mut self, prior: &StartPrior) {
        self.begin_again(prior.clone());
    }

    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        self.num_weighed = 0;
        if input.is_lifted {
            self.motion.update(input.percept.at, input.odometry);
            self.begin_again(StartPrior::Uniform);
            return &self.estimate;
        }
        let motion = self.propagate(input.percept.at, input.odometry, rng);
        self.model.condition_on(input.percept);
        if !self.model.has_evidence() {
            self.go_blind(motion.as_ref());
            return &self.estimate;
        }
        if let Some(motion) = motion {
            self.estimate.move_by(&motion);
        }
        self.motion.note_evidence();
        if self.particles.is_empty() {
            self.waited += 1;
            let can_wait = self.prior.is_uniform() && self.waited <= self.config.initialization.max_wait;
            if !input.percept.is_informative && can_wait {
                return &self.estimate;
            }
            self.start(rng);
        }
        self.weigh();
        if self.must_restart() {
            self.prior = StartPrior::Uniform;
            self.start(rng);
            self.weigh();
        }
        self.update_estimate(input.percept.quality);
        self.resample(rng);
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    fn individuals(&self, out: &mut Vec<Individual>) {
        let particles = self.particles.poses().iter().zip(self.particles.likelihoods());
        out.extend(particles.map(|(pose, likelihood)| Individual {
            world_from_robot: *pose,
            likelihood: *likelihood,
            population: 0,
        }));
    }

    fn num_weighed(&self) -> usize {
        self.num_weighed
    }
}
