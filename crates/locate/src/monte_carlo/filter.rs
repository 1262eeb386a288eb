//! The particle filter: motion, weights, estimate, survivors.

use rand::RngExt;
use visloc_base::{Rng, gaussian};
use visloc_geom::{PlanarPose, weighted_pose_statistics};

use super::{Clusters, MonteCarloConfig};
use crate::{
    ConfigError, Estimate, Individual, Localizer, MotionModel, ObservationModel, PlanarMotion, Reliability,
    StepInput,
};

/// A particle filter over planar poses.
pub struct MonteCarlo {
    config: MonteCarloConfig,
    model: Box<dyn ObservationModel>,
    motion: MotionModel,
    reliability: Reliability,
    /// Particles; after resampling the elite comes first.
    poses: Vec<PlanarPose>,
    likelihoods: Vec<f64>,
    weights: Vec<f64>,
    num_elite: usize,
    /// Images since the start was wished for.
    waited: u32,
    /// Images in a row that no particle explained.
    unexplained: u32,
    order: Vec<usize>,
    drawn: Vec<usize>,
    next: Vec<PlanarPose>,
    clusters: Clusters,
    estimate: Estimate,
}

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
            poses: Vec::new(),
            likelihoods: Vec::new(),
            weights: Vec::new(),
            num_elite: 0,
            waited: 0,
            unexplained: 0,
            order: Vec::new(),
            drawn: Vec::new(),
            next: Vec::new(),
            clusters: Clusters::default(),
            estimate: Estimate::unknown(),
        })
    }

    /// Particles all over the map, some of them aimed at what is seen.
    fn start(&mut self, rng: &mut Rng) {
        let region = self.model.region();
        self.poses.clear();
        for _ in 0..self.config.num_particles {
            let is_aimed = rng.random_bool(self.config.aimed_share);
            self.poses.push(if is_aimed { self.model.propose(rng) } else { region.sample(rng) });
        }
        self.num_elite = 0;
        self.unexplained = 0;
        self.reliability.reset();
    }

    /// Moves all particles; the elite without noise.
    fn apply_motion(&mut self, motion: &PlanarMotion, rng: &mut Rng) {
        let num_elite = self.num_elite.min(self.poses.len());
        let (elite, others) = self.poses.split_at_mut(num_elite);
        elite.iter_mut().for_each(|pose| *pose = motion.apply(pose));
        others.iter_mut().for_each(|pose| *pose = motion.sample(pose, rng));
        self.estimate.world_from_robot = motion.apply(&self.estimate.world_from_robot);
        for hypothesis in &mut self.estimate.hypotheses {
            hypothesis.world_from_robot = motion.apply(&hypothesis.world_from_robot);
        }
    }

    fn weigh(&mut self) {
        let region = self.model.region();
        self.likelihoods.clear();
        self.weights.clear();
        for pose in &self.poses {
            let likelihood = if region.contains(pose) { self.model.likelihood(pose) } else { 0.0 };
            self.likelihoods.push(likelihood);
            self.weights.push(likelihood.powf(self.config.weight_exponent));
        }
        self.order.clear();
        self.order.extend(0..self.poses.len());
        let likelihoods = &self.likelihoods;
        self.order.sort_unstable_by(|a, b| likelihoods[*b].total_cmp(&likelihoods[*a]).then(a.cmp(b)));
    }

    /// Whether no particle has explained the images for too long.
    fn must_restart(&mut self) -> bool {
        let best = self.likelihoods[self.order[0]];
        self.unexplained = if best < self.config.restart_likelihood { self.unexplained + 1 } else { 0 };
        self.unexplained >= self.config.restart_after
    }

    /// Weighted mean of the best particles, and hypotheses from all of them.
    fn update_estimate(&mut self, quality: f64) {
        let best = &self.order[..share(self.config.estimate_share, self.poses.len()).max(1)];
        let members = best.iter().map(|i| (self.poses[*i], self.weights[*i]));
        let Some(statistics) = weighted_pose_statistics(members) else { return };
        #[allow(clippy::cast_precision_loss)]
        let likelihood = best.iter().map(|i| self.likelihoods[*i]).sum::<f64>() / best.len() as f64;
        self.reliability.update(likelihood, quality);
        let estimate = &mut self.estimate;
        estimate.world_from_robot = statistics.mean;
        estimate.likelihood = likelihood;
        estimate.reliability = self.reliability.value();
        estimate.hypotheses.clear();
        self.clusters.find(&self.config.clusters, &self.poses, &self.weights, &mut estimate.hypotheses);
        estimate.normalize_hypotheses();
        if let Some(all) =
            weighted_pose_statistics(self.poses.iter().copied().zip(self.weights.iter().copied()))
        {
            estimate.covariance = all.covariance;
        }
    }

    /// The elite unchanged, the rest drawn by weight with noise.
    fn resample(&mut self, rng: &mut Rng) {
        let config = &self.config;
        self.num_elite = share(config.elite_share, self.poses.len());
        self.next.clear();
        self.next.extend(self.order[..self.num_elite].iter().map(|i| self.poses[*i]));
        self.drawn.clear();
        config.resampling.draw(&self.weights, self.poses.len() - self.num_elite, rng, &mut self.drawn);
        let misfit = (config.fit_likelihood - self.estimate.likelihood).max(0.0);
        let growth = 1.0 + config.noise_growth * misfit * 10.0;
        for &i in &self.drawn {
            let pose = self.poses[i];
            self.next.push(PlanarPose::new(
                pose.x_m + gaussian(rng, config.position_noise_m * growth),
                pose.y_m + gaussian(rng, config.position_noise_m * growth),
                pose.yaw_rad + gaussian(rng, config.heading_noise_rad * growth),
            ));
        }
        std::mem::swap(&mut self.poses, &mut self.next);
    }
}

/// A share of a number, rounded.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn share(share: f64, of: usize) -> usize {
    (share * of as f64).round() as usize
}

impl Localizer for MonteCarlo {
    fn reset(&mut self) {
        self.poses.clear();
        self.likelihoods.clear();
        self.num_elite = 0;
        self.waited = 0;
        self.unexplained = 0;
        self.reliability.reset();
        self.estimate.reliability = 0.0;
        self.estimate.hypotheses.clear();
    }

    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        let motion = self.motion.update(input.odometry);
        if input.is_lifted {
            self.reset();
            return &self.estimate;
        }
        if let Some(motion) = motion {
            self.apply_motion(&motion, rng);
        }
        self.model.condition_on(input.percept);
        if !self.model.has_evidence() {
            return &self.estimate;
        }
        if self.poses.is_empty() {
            self.waited += 1;
            if !input.percept.is_informative && self.waited <= self.config.max_start_wait {
                return &self.estimate;
            }
            self.start(rng);
        }
        self.weigh();
        if self.must_restart() {
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
        out.extend(self.poses.iter().map(|pose| Individual {
            world_from_robot: *pose,
            likelihood: self.estimate.likelihood,
            population: 0,
        }));
    }
}
