//! Parameters of the evolutionary algorithm.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// Parameters of the explorers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExplorerConfig {
    /// How they are spread.
    pub kind: ExplorerKind,
    /// Whether their heading is aimed at what is seen, instead of taking all headings. Source of the idea: 2017
    /// section 4.2.2, explorers placed by abduction.
    pub is_aimed: bool,
    /// Explorers of an ordinary random search.
    #[schemars(extend("x-only-if" = "kind = random"))]
    pub num_random: usize,
    /// A deep search, at the start or when lost, has so many times as many. Source: 2017 section 4.2.2, at least 10.
    #[schemars(extend("x-only-if" = "kind = random"))]
    pub deep_factor: usize,
    /// Poses of the fixed grid. Source: 2010 section 5.2.1, 490.
    #[schemars(extend("x-only-if" = "kind = grid"))]
    pub num_grid: usize,
    /// The best so many become candidates for a race. Source: 2010 section 5.2.1, 6.
    pub num_candidates: usize,
    /// Iterations between two searches.
    pub period: u32,
    /// Whether the candidates are refined by a local search of 34 poses each. Source: 2010 section 5.2.1.
    pub is_refined: bool,
    /// The spreading is divided over this many iterations, and the refinement takes one iteration for two
    /// candidates, so that no iteration stands out. Source of the idea: 2010 section 5.2.1, four iterations in all.
    pub num_slices: u32,
}

impl Default for ExplorerConfig {
    fn default() -> Self {
        Self {
            kind: ExplorerKind::Random,
            is_aimed: true,
            num_random: 50,
            deep_factor: 20,
            num_grid: 490,
            num_candidates: 6,
            period: 10,
            is_refined: true,
            num_slices: 8,
        }
    }
}

/// Evidence that adds up over the images, for worlds where many places look alike for a while. The documents have none:
/// there, the race that explains the newest image best wins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EvidenceConfig {
    /// What a health that is lower by 1 takes from the logarithm of a race's odds in each image; 0 switches evidence off.
    pub per_image: f64,
    /// Smaller differences of the health say nothing ...
    #[schemars(extend("x-only-if" = "per_image > 0"))]
    pub deadband: f64,
    /// ... and larger ones no more than this: one image with something strange in it must not decide.
    #[schemars(extend("x-only-if" = "per_image > 0"))]
    pub max_difference: f64,
    /// Share of the evidence that is kept from image to image.
    #[schemars(extend("x-only-if" = "per_image > 0"))]
    pub kept: f64,
    /// A new race begins with this much less than the best one, as a logarithm of odds, while nothing is known ...
    #[schemars(extend("x-only-if" = "per_image > 0"))]
    pub newcomer_handicap: f64,
    /// ... and with this much less when the answer is fully reliable.
    #[schemars(extend("x-only-if" = "per_image > 0"))]
    pub late_handicap: f64,
    /// A race that has this much less than the best one is given up, as a logarithm of odds.
    #[schemars(extend("x-only-if" = "per_image > 0"))]
    pub hopeless: f64,
}

impl Default for EvidenceConfig {
    fn default() -> Self {
        Self {
            per_image: 0.0,
            deadband: 0.01,
            max_difference: 0.1,
            kept: 0.998,
            newcomer_handicap: 2.0,
            late_handicap: 10.0,
            hopeless: 12.0,
        }
    }
}

impl EvidenceConfig {
    /// Whether evidence is counted at all.
    pub(super) fn is_on(&self) -> bool {
        self.per_image > 0.0
    }

    fn check(&self) -> Result<(), ConfigError> {
        require((0.0..=1000.0).contains(&self.per_image), "evidence.per_image", "0 to 1000", self.per_image)?;
        require((0.0..1.0).contains(&self.deadband), "evidence.deadband", "0 to below 1", self.deadband)?;
        let largest = self.max_difference;
        let is_larger = largest > self.deadband && largest <= 1.0;
        require(is_larger, "evidence.max_difference", "above deadband, at most 1", largest)?;
        require((0.0..=1.0).contains(&self.kept), "evidence.kept", "0 to 1", self.kept)?;
        let (newcomer, late) = (self.newcomer_handicap, self.late_handicap);
        require((0.0..=100.0).contains(&newcomer), "evidence.newcomer_handicap", "0 to 100", newcomer)?;
        let is_later = late >= newcomer && late <= 100.0;
        require(is_later, "evidence.late_handicap", "newcomer_handicap to 100", late)?;
        let hopeless = self.hopeless;
        require(
            hopeless > late && hopeless <= 1000.0,
            "evidence.hopeless",
            "above late_handicap, at most 1000",
            hopeless,
        )
    }

    /// What a new race lacks against the best one, given the reliability of the answer.
    pub(super) fn handicap(&self, reliability: f64) -> f64 {
        self.newcomer_handicap + reliability * (self.late_handicap - self.newcomer_handicap)
    }
}

/// Parameters of the evolutionary algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EvolutionaryConfig {
    /// Most races. Source: 2010 section 5.2.6, 4.
    pub max_races: usize,
    /// Most exploiters of each race. Source: 2010 section 5.2.6, 30.
    pub num_exploiters: usize,
    /// Most exploiters of all races together. If the races would have more, they share this number equally: few places
    /// get a large race each, many places a small one, and an iteration costs the same.
    pub max_exploiters: usize,
    /// Share of the exploiters that survive unchanged. Source: 2010 section 5.2.6, 0.2.
    pub elite_share: f64,
    /// Share of the exploiters that are the mean of two others. Source: 2010 section 5.2.6, 0.2.
    pub crossover_share: f64,
    /// An exploiter's weight in means is its health to this power.
    pub weight_exponent: f64,
    /// Thermal noise of the first generation, meters.
    pub birth_noise_m: f64,
    /// Thermal noise of the first generation, radians.
    pub birth_noise_rad: f64,
    /// Thermal noise of a mutation, meters.
    pub mutation_noise_m: f64,
    /// Thermal noise of a mutation, radians.
    pub mutation_noise_rad: f64,
    /// The noise grows by this much for each 0.1 that the race's health lies below `fit_health`.
    pub noise_growth: f64,
    /// Health of a good fit, from which on the noise is smallest.
    #[schemars(extend("x-only-if" = "noise_growth > 0"))]
    pub fit_health: f64,
    /// Iterations a new race cannot be deleted. Source: 2010 section 5.2.2, 3.
    pub birth_life: u32,
    /// Iterations the healthiest race cannot be deleted. Source: 2010 section 5.2.2, 9.
    pub winner_life: u32,
    /// Victories are counted up to this, so that an old winner can be overtaken.
    pub max_victories: u32,
    /// Below this health a race without life and victories is deleted. Source: 2010 section 5.2.2, 0.6.
    pub min_health: f64,
    /// Races nearer than this and `merge_turn_rad` are one, meters.
    pub merge_distance_m: f64,
    /// Largest difference of the heading of races that are one, radians.
    pub merge_turn_rad: f64,
    /// To take a victory from the previous winner a race must be healthier by this ...
    pub takeover_health: f64,
    /// ... and by this times the reliability ...
    pub takeover_per_reliability: f64,
    /// ... and by this if the image shows nothing informative.
    pub takeover_uninformative: f64,
    /// All races below this health: the robot is lost and a deep search is made.
    pub lost_health: f64,
    /// How fast a race's health follows the images: share of the newest image, 0 to 1. The documents use 1.
    pub health_follow: f64,
    /// Whether a race is founded where the robot was before it was lifted: somebody may have set it back.
    pub keeps_old_pose: bool,
    /// Evidence over many images.
    pub evidence: EvidenceConfig,
    /// Explorers.
    pub explorers: ExplorerConfig,
    /// Motion model.
    pub motion: MotionConfig,
    /// Reliability of the estimate.
    pub reliability: ReliabilityConfig,
}

impl Default for EvolutionaryConfig {
    fn default() -> Self {
        Self {
            max_races: 4,
            num_exploiters: 30,
            max_exploiters: 120,
            elite_share: 0.2,
            crossover_share: 0.2,
            weight_exponent: 20.0,
            birth_noise_m: 0.2,
            birth_noise_rad: 0.1,
            mutation_noise_m: 0.02,
            mutation_noise_rad: 0.015,
            noise_growth: 1.5,
            fit_health: 0.92,
            birth_life: 3,
            winner_life: 9,
            max_victories: 60,
            min_health: 0.6,
            merge_distance_m: 0.4,
            merge_turn_rad: 0.35,
            takeover_health: 0.02,
            takeover_per_reliability: 0.04,
            takeover_uninformative: 0.08,
            lost_health: 0.7,
            health_follow: 0.3,
            keeps_old_pose: false,
            evidence: EvidenceConfig::default(),
            explorers: ExplorerConfig::default(),
            motion: MotionConfig::default(),
            reliability: ReliabilityConfig::default(),
        }
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

    /// Checks the ranges of all values.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        require((1..=1000).contains(&self.max_races), "max_races", "1 to 1000", self.max_races)?;
        require(
            (3..=100_000).contains(&self.num_exploiters),
            "num_exploiters",
            "3 to 100000",
            self.num_exploiters,
        )?;
        let least = 3 * self.max_races;
        require(
            (least..=1_000_000).contains(&self.max_exploiters),
            "max_exploiters",
            "3 for each of max_races to 1000000",
            self.max_exploiters,
        )?;
        for (key, value) in [("elite_share", self.elite_share), ("crossover_share", self.crossover_share)] {
            require((0.0..1.0).contains(&value), key, "at least 0 and below 1", value)?;
        }
        let kept = self.elite_share + self.crossover_share;
        require(kept <= 1.0, "elite_share + crossover_share", "at most 1", kept)?;
        require(
            self.elite_share > 0.0,
            "elite_share",
            "above 0: the elite is the race's pose",
            self.elite_share,
        )?;
        for (key, value) in [
            ("weight_exponent", self.weight_exponent),
            ("birth_noise_m", self.birth_noise_m),
            ("birth_noise_rad", self.birth_noise_rad),
            ("mutation_noise_m", self.mutation_noise_m),
            ("mutation_noise_rad", self.mutation_noise_rad),
            ("noise_growth", self.noise_growth),
            ("merge_distance_m", self.merge_distance_m),
            ("merge_turn_rad", self.merge_turn_rad),
        ] {
            require((0.0..=1000.0).contains(&value), key, "0 to 1000", value)?;
        }
        for (key, value) in [
            ("fit_health", self.fit_health),
            ("min_health", self.min_health),
            ("takeover_health", self.takeover_health),
            ("takeover_per_reliability", self.takeover_per_reliability),
            ("takeover_uninformative", self.takeover_uninformative),
            ("lost_health", self.lost_health),
        ] {
            require((0.0..=1.0).contains(&value), key, "0 to 1", value)?;
        }
        let follow = self.health_follow;
        require(follow > 0.0 && follow <= 1.0, "health_follow", "above 0, at most 1", follow)?;
        require(self.max_victories > 0, "max_victories", "at least 1", self.max_victories)?;
        self.evidence.check()?;
        self.check_explorers()?;
        self.motion.check()?;
        self.reliability.check()
    }

    fn check_explorers(&self) -> Result<(), ConfigError> {
        let e = &self.explorers;
        for (key, value) in [
            ("explorers.num_random", e.num_random),
            ("explorers.deep_factor", e.deep_factor),
            ("explorers.num_grid", e.num_grid),
            ("explorers.num_candidates", e.num_candidates),
            ("explorers.period", e.period as usize),
            ("explorers.num_slices", e.num_slices as usize),
        ] {
            require((1..=1_000_000).contains(&value), key, "1 to 1000000", value)?;
        }
        Ok(())
    }
}
