//! Parameters of the particle filter.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use super::{
    ClusterConfig, EstimateConfig, EstimateKind, InjectionConfig, InjectionSource, Resampling,
    ResamplingConfig, SampleSizeConfig, SampleSizeRule,
};
use crate::{ConfigError, MotionConfig, ReliabilityConfig, require};

visloc_core::with_defaults! {
    /// How the filter begins.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct InitializationConfig {
        /// Share of the first particles whose heading is aimed at something seen; the rest has any heading. The documents
        /// have 0 in section 4.1.1 of 2017, which allows both.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub aimed_share: f64 = 0.8,
        /// Without a prior the filter waits this many images for an informative one before it starts.
        pub max_wait: u32 = 90,
        /// After a lift this share of the particles is put around the last pose that could be relied on: somebody may have
        /// set the robot back. 0 forgets it.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub keep_old_pose_share: f64 = 0.0,
        /// Spread around that pose, meters.
        #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
        #[schemars(range(min = 0.0, max = 100.0))]
        pub old_pose_noise_m: f64 = 0.3,
        /// Spread around its heading, radians.
        #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
        #[schemars(range(min = 0.0, max = 100.0))]
        pub old_pose_noise_rad: f64 = 0.3,
    }
}

visloc_core::with_defaults! {
    /// Noise on the copies that survive; the elite has none.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct NoiseConfig {
        /// Standard deviation of x and y, meters.
        #[schemars(range(min = 0.0, max = 100.0))]
        pub position_m: f64 = 0.02,
        /// Standard deviation of the heading, radians.
        #[schemars(range(min = 0.0, max = 100.0))]
        pub heading_rad: f64 = 0.015,
        /// The noise grows by this much for each 0.1 that the estimate's likelihood lies below `fit_likelihood`: a poor fit
        /// searches wider. The documents have 0.
        #[schemars(range(min = 0.0, max = 100.0))]
        pub growth: f64 = 2.0,
        /// Likelihood of a good fit, from which on the noise is smallest.
        #[schemars(extend("x-only-if" = "growth > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub fit_likelihood: f64 = 0.92,
    }
}

visloc_core::with_defaults! {
    /// When the filter gives up and starts anew. Source: 2017 section 4.1.1, which leaves the values open.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct RestartConfig {
        /// While every particle is below this likelihood (0: never) ...
        #[schemars(range(min = 0.0, max = 1.0))]
        pub min_likelihood: f64 = 0.7,
        /// ... for this many images that say something, the filter starts anew, anywhere on the map.
        #[schemars(extend("x-only-if" = "min_likelihood > 0"))]
        #[schemars(range(min = 1, max = 1_000_000))]
        pub after: u32 = 15,
    }
}

visloc_core::with_defaults! {
    /// Parameters of a particle filter. The variants of the documents differ in them only.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct MonteCarloConfig {
        /// How many particles, at most if the number follows a rule. Source: 2010 section 5.1.4, 200.
        #[schemars(range(min = 2, max = 10_000_000))]
        pub num_particles: usize = 200,
        /// Share of the particles that survive unchanged, 0 for the classic filter. Source: 2010 section 5.1.4, 0.1.
        #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
        pub elite_share: f64 = 0.1,
        /// A particle's weight is its likelihood to this power; 1 in the documents, where a particle that explains the
        /// image weighs hardly more than one that does not.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub weight_exponent: f64 = 20.0,
        /// From this many particles on they are weighed on all processors, with the same result bit by bit. Two processors are
        /// 1.9 times as fast from 512 on with images, at half a microsecond a particle; with a world that is a formula of a few
        /// nanoseconds they never pay.
        pub parallel_from: usize = 512,
        /// Beginning.
        pub initialization: InitializationConfig = InitializationConfig::default(),
        /// Drawing of survivors.
        pub resampling: ResamplingConfig = ResamplingConfig::default(),
        /// Noise on survivors.
        pub noise: NoiseConfig = NoiseConfig::default(),
        /// Random particles.
        pub injection: InjectionConfig = InjectionConfig::default(),
        /// Number of particles.
        pub sample_size: SampleSizeConfig = SampleSizeConfig::default(),
        /// New start.
        pub restart: RestartConfig = RestartConfig::default(),
        /// What is answered.
        pub estimate: EstimateConfig = EstimateConfig::default(),
        /// How particles are grouped into hypotheses.
        pub clusters: ClusterConfig = ClusterConfig::default(),
        /// Motion model.
        pub motion: MotionConfig = MotionConfig::default(),
        /// Reliability of the estimate.
        pub reliability: ReliabilityConfig = ReliabilityConfig::default(),
    }
}

impl MonteCarloConfig {
    /// The classic filter (MC): no elite.
    pub fn classic() -> Self {
        Self { elite_share: 0.0, ..Self::default() }
    }

    /// The classic filter with the resampling that keeps most of the variety.
    pub fn systematic() -> Self {
        let resampling = ResamplingConfig { scheme: Resampling::Systematic, ..ResamplingConfig::default() };
        Self { resampling, ..Self::classic() }
    }

    /// The augmented filter (MCA): random particles when the images are explained worse than before, and the largest group of
    /// good particles is the answer. Source: 2017 sections 4.1.3 and 4.1.4.
    pub fn augmented() -> Self {
        let injection = InjectionConfig {
            max_share: 1.0,
            source: InjectionSource::Proposed,
            ..InjectionConfig::default()
        };
        let estimate = EstimateConfig { kind: EstimateKind::LargestCluster, ..EstimateConfig::default() };
        Self { injection, estimate, ..Self::classic() }
    }

    /// The augmented filter with elitism (MCAe).
    pub fn augmented_elite() -> Self {
        Self { elite_share: Self::default().elite_share, ..Self::augmented() }
    }

    /// As many particles as needed (KLD-sampling), systematic resampling, and a minimum for each hypothesis. The start
    /// takes 3,000 particles; a robot that knows where it is on a field takes about 200.
    pub fn kld() -> Self {
        let sample_size = SampleSizeConfig {
            rule: SampleSizeRule::Kld,
            max_error: 0.03,
            min_particles: 120,
            min_per_hypothesis: 20,
            ..SampleSizeConfig::default()
        };
        Self { num_particles: 3000, sample_size, ..Self::systematic() }
    }

    /// Checks the ranges of all values, and those that must go together.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        let kept = self.sample_size.min_per_hypothesis;
        let has_groups = kept == 0 || self.clusters.max_clusters > 0;
        require(has_groups, "sample_size.min_per_hypothesis", "0 if clusters.max_clusters is 0", kept)?;
        self.injection.check()?;
        self.motion.check()?;
        self.reliability.check()
    }
}
