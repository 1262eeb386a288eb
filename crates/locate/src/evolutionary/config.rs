//! Parameters of the evolutionary algorithm.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use crate::{ConfigError, MotionConfig, ReliabilityConfig, require};

/// How explorers are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExplorerKind {
    /// At random over the map. Source: 2017 section 4.2.2.
    Random,
    /// On a fixed grid. Source: 2010 section 5.2.1.
    Grid,
}

visloc_core::with_defaults! {
    /// Parameters of the explorers.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct ExplorerConfig {
        /// How they are spread.
        pub kind: ExplorerKind = ExplorerKind::Random,
        /// Whether their heading is aimed at what is seen, instead of taking all headings. Source of the idea: 2017
        /// section 4.2.2, explorers placed by abduction.
        pub is_aimed: bool = true,
        /// Explorers of an ordinary random search.
        #[schemars(extend("x-only-if" = "kind = random"))]
        #[schemars(range(min = 1, max = 1_000_000))]
        pub num_random: usize = 50,
        /// A deep search, at the start or when lost, has so many times as many. Source: 2017 section 4.2.2, at least 10.
        #[schemars(extend("x-only-if" = "kind = random"))]
        #[schemars(range(min = 1, max = 1_000_000))]
        pub deep_factor: usize = 20,
        /// Poses of the fixed grid. Source: 2010 section 5.2.1, 490.
        #[schemars(extend("x-only-if" = "kind = grid"))]
        #[schemars(range(min = 1, max = 1_000_000))]
        pub num_grid: usize = 490,
        /// The best so many become candidates for a race. Source: 2010 section 5.2.1, 6.
        #[schemars(range(min = 1, max = 1_000_000))]
        pub num_candidates: usize = 6,
        /// Iterations between two searches.
        #[schemars(range(min = 1, max = 1_000_000))]
        pub period: u32 = 10,
        /// Whether the candidates are refined by a local search of 34 poses each. Source: 2010 section 5.2.1.
        pub is_refined: bool = true,
        /// The spreading is divided over this many iterations, and the refinement takes one iteration for two
        /// candidates, so that no iteration stands out. Source of the idea: 2010 section 5.2.1, four iterations in all.
        #[schemars(range(min = 1, max = 1_000_000))]
        pub num_slices: u32 = 8,
    }
}

visloc_core::with_defaults! {
    /// Evidence that adds up over the images, for worlds where many places look alike for a while. The documents have none:
    /// there, the race that explains the newest image best wins.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct EvidenceConfig {
        /// What a health that is lower by 1 takes from the logarithm of a race's odds in each image; 0 switches evidence off.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub per_image: f64 = 0.0,
        /// Smaller differences of the health say nothing ...
        #[schemars(extend("x-only-if" = "per_image > 0"))]
        #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
        pub deadband: f64 = 0.01,
        /// ... and larger ones no more than this: one image with something strange in it must not decide.
        #[schemars(extend("x-only-if" = "per_image > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub max_difference: f64 = 0.1,
        /// Share of the evidence that is kept from image to image.
        #[schemars(extend("x-only-if" = "per_image > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub kept: f64 = 0.998,
        /// A new race begins with this much less than the best one, as a logarithm of odds, while nothing is known ...
        #[schemars(extend("x-only-if" = "per_image > 0"))]
        #[schemars(range(min = 0.0, max = 100.0))]
        pub newcomer_handicap: f64 = 2.0,
        /// ... and with this much less when the answer is fully reliable.
        #[schemars(extend("x-only-if" = "per_image > 0"))]
        #[schemars(range(min = 0.0, max = 100.0))]
        pub late_handicap: f64 = 10.0,
        /// A race that has this much less than the best one is given up, as a logarithm of odds.
        #[schemars(extend("x-only-if" = "per_image > 0"))]
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub hopeless: f64 = 12.0,
    }
}

impl EvidenceConfig {
    /// Whether evidence is counted at all.
    pub(super) fn is_on(&self) -> bool {
        self.per_image > 0.0
    }

    fn check(&self) -> Result<(), ConfigError> {
        let (largest, late) = (self.max_difference, self.late_handicap);
        require(largest > self.deadband, "evidence.max_difference", "above deadband", largest)?;
        let is_later = late >= self.newcomer_handicap;
        require(is_later, "evidence.late_handicap", "at least newcomer_handicap", late)?;
        require(self.hopeless > late, "evidence.hopeless", "above late_handicap", self.hopeless)
    }

    /// What a new race lacks against the best one, given the reliability of the answer.
    pub(super) fn handicap(&self, reliability: f64) -> f64 {
        self.newcomer_handicap + reliability * (self.late_handicap - self.newcomer_handicap)
    }
}

visloc_core::with_defaults! {
    /// Parameters of the evolutionary algorithm.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct EvolutionaryConfig {
        /// Most races. Source: 2010 section 5.2.6, 4.
        #[schemars(range(min = 1, max = 1000))]
        pub max_races: usize = 4,
        /// Most exploiters of each race. Source: 2010 section 5.2.6, 30.
        #[schemars(range(min = 3, max = 100_000))]
        pub num_exploiters: usize = 30,
        /// Most exploiters of all races together. If the races would have more, they share this number equally: few places
        /// get a large race each, many places a small one, and an iteration costs the same.
        #[schemars(range(min = 3, max = 1_000_000))]
        pub max_exploiters: usize = 120,
        /// Share of the exploiters that survive unchanged: the elite is the race's pose. Source: 2010 section 5.2.6, 0.2.
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
        pub elite_share: f64 = 0.2,
        /// Share of the exploiters that are the mean of two others. Source: 2010 section 5.2.6, 0.2.
        #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
        pub crossover_share: f64 = 0.2,
        /// An exploiter's weight in means is its health to this power.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub weight_exponent: f64 = 20.0,
        /// Thermal noise of the first generation, meters.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub birth_noise_m: f64 = 0.2,
        /// Thermal noise of the first generation, radians.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub birth_noise_rad: f64 = 0.1,
        /// Thermal noise of a mutation, meters.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub mutation_noise_m: f64 = 0.02,
        /// Thermal noise of a mutation, radians.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub mutation_noise_rad: f64 = 0.015,
        /// The noise grows by this much for each 0.1 that the race's health lies below `fit_health`.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub noise_growth: f64 = 1.5,
        /// Health of a good fit, from which on the noise is smallest.
        #[schemars(extend("x-only-if" = "noise_growth > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub fit_health: f64 = 0.92,
        /// Iterations a new race cannot be deleted. Source: 2010 section 5.2.2, 3.
        pub birth_life: u32 = 3,
        /// Iterations the healthiest race cannot be deleted. Source: 2010 section 5.2.2, 9.
        pub winner_life: u32 = 9,
        /// Victories are counted up to this, so that an old winner can be overtaken.
        #[schemars(range(min = 1, max = 1_000_000))]
        pub max_victories: u32 = 60,
        /// Below this health a race without life and victories is deleted. Source: 2010 section 5.2.2, 0.6.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub min_health: f64 = 0.6,
        /// Races nearer than this and `merge_turn_rad` are one, meters.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub merge_distance_m: f64 = 0.4,
        /// Largest difference of the heading of races that are one, radians.
        #[schemars(range(min = 0.0, max = 1000.0))]
        pub merge_turn_rad: f64 = 0.35,
        /// To take a victory from the previous winner a race must be healthier by this ...
        #[schemars(range(min = 0.0, max = 1.0))]
        pub takeover_health: f64 = 0.02,
        /// ... and by this times the reliability ...
        #[schemars(range(min = 0.0, max = 1.0))]
        pub takeover_per_reliability: f64 = 0.04,
        /// ... and by this if the image shows nothing informative.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub takeover_uninformative: f64 = 0.08,
        /// All races below this health: the robot is lost and a deep search is made.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub lost_health: f64 = 0.7,
        /// How fast a race's health follows the images: share of the newest image, 0 to 1. The documents use 1.
        #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
        pub health_follow: f64 = 0.3,
        /// Whether a race is founded where the robot was before it was lifted: somebody may have set it back.
        pub keeps_old_pose: bool = false,
        /// Evidence over many images.
        pub evidence: EvidenceConfig = EvidenceConfig::default(),
        /// Explorers.
        pub explorers: ExplorerConfig = ExplorerConfig::default(),
        /// Motion model.
        pub motion: MotionConfig = MotionConfig::default(),
        /// Reliability of the estimate.
        pub reliability: ReliabilityConfig = ReliabilityConfig::default(),
    }
}

impl EvolutionaryConfig {
    /// Exploiters of each race when there are so many races.
    pub(super) fn race_size(&self, num_races: usize) -> usize {
        self.num_exploiters.min(self.max_exploiters / num_races.max(1))
    }

    /// An exploiter's weight in means.
    pub(super) fn weight(&self, health: f64) -> f64 {
        // Exact, and much faster in the plain case.
        if self.weight_exponent == 1.0 { health } else { health.powf(self.weight_exponent) }
    }

    /// Checks the ranges of all values, and those that must go together.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        let most = self.max_exploiters;
        require(most >= 3 * self.max_races, "max_exploiters", "3 for each of max_races", most)?;
        let kept = self.elite_share + self.crossover_share;
        require(kept <= 1.0, "elite_share + crossover_share", "at most 1", kept)?;
        self.evidence.check()?;
        self.motion.check()?;
        self.reliability.check()
    }
}
