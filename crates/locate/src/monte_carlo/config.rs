//! Parameters of the particle filter.

use serde::{Deserialize, Serialize};

use super::{ClusterConfig, Resampling};
use crate::{ConfigError, MotionConfig, ReliabilityConfig, require};

/// Parameters of a particle filter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MonteCarloConfig {
    /// How many particles. Source: 2010 section 5.1.4, 200.
    pub num_particles: usize,
    /// Share of the particles that survive unchanged, 0 for the classic filter. Source: 2010 section 5.1.4, 0.1.
    pub elite_share: f64,
    /// Share of the best particles whose weighted mean is the estimate.
    pub estimate_share: f64,
    /// How survivors are drawn.
    pub resampling: Resampling,
    /// A particle's weight is its likelihood to this power; 1 in the documents, where a particle that explains the
    /// image weighs hardly more than one that does not.
    pub weight_exponent: f64,
    /// Standard deviation of the noise on a drawn copy's position, meters.
    pub position_noise_m: f64,
    /// Standard deviation of the noise on a drawn copy's heading, radians.
    pub heading_noise_rad: f64,
    /// The noise grows by this much for each 0.1 that the elite's likelihood lies below `fit_likelihood`: a poor fit
    /// searches wider.
    pub noise_growth: f64,
    /// Likelihood of a good fit, from which on the noise is smallest.
    pub fit_likelihood: f64,
    /// Share of the first particles whose heading is aimed at a seen goal; the rest is uniform.
    pub aimed_share: f64,
    /// While every particle is below this likelihood ...
    pub restart_likelihood: f64,
    /// ... for this many images that say something, the filter starts anew.
    pub restart_after: u32,
    /// The filter waits this many images for an informative one before it starts.
    pub max_start_wait: u32,
    /// How the drawn copies are grouped into hypotheses.
    pub clusters: ClusterConfig,
    /// Motion model.
    pub motion: MotionConfig,
    /// Reliability of the estimate.
    pub reliability: ReliabilityConfig,
}

impl Default for MonteCarloConfig {
    fn default() -> Self {
        Self {
            num_particles: 200,
            elite_share: 0.1,
            estimate_share: 0.1,
            resampling: Resampling::Roulette,
            weight_exponent: 20.0,
            position_noise_m: 0.02,
            heading_noise_rad: 0.015,
            noise_growth: 2.0,
            fit_likelihood: 0.92,
            aimed_share: 0.8,
            restart_likelihood: 0.7,
            restart_after: 15,
            max_start_wait: 90,
            clusters: ClusterConfig::default(),
            motion: MotionConfig::default(),
            reliability: ReliabilityConfig::default(),
        }
    }
}

impl MonteCarloConfig {
    /// The classic filter: no elite.
    #[must_use]
    pub fn classic() -> Self {
        Self { elite_share: 0.0, ..Self::default() }
    }

    /// Checks the ranges of all values.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        require(
            (2..=1_000_000).contains(&self.num_particles),
            "num_particles",
            "2 to 1000000",
            self.num_particles,
        )?;
        require(
            (0.0..1.0).contains(&self.elite_share),
            "elite_share",
            "at least 0 and below 1",
            self.elite_share,
        )?;
        for (key, value) in [
            ("estimate_share", self.estimate_share),
            ("weight_exponent", self.weight_exponent / 1000.0),
            ("fit_likelihood", self.fit_likelihood),
        ] {
            require(value > 0.0 && value <= 1.0, key, "above 0 (shares and likelihoods at most 1)", value)?;
        }
        for (key, value) in [
            ("position_noise_m", self.position_noise_m),
            ("heading_noise_rad", self.heading_noise_rad),
            ("noise_growth", self.noise_growth),
        ] {
            require((0.0..=100.0).contains(&value), key, "0 to 100", value)?;
        }
        for (key, value) in
            [("aimed_share", self.aimed_share), ("restart_likelihood", self.restart_likelihood)]
        {
            require((0.0..=1.0).contains(&value), key, "0 to 1", value)?;
        }
        require(self.restart_after > 0, "restart_after", "at least 1", self.restart_after)?;
        self.clusters.check()?;
        self.motion.check()?;
        self.reliability.check()
    }
}
