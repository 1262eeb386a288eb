//! Parameters of Markov localization.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Outcomes;
use crate::{ConfigError, MotionConfig, require};

/// What is done against runs of observations without a landmark. The source names the trouble as open work: such
/// observations raise the belief of many states, and the robot recovers slowly afterwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Remedy {
    /// Weight of the first observation of a run, 0 to 1: the power to which its likelihood is raised.
    pub first_weight: f64,
    /// Each further one weighs this share of the one before, 0 to 1. A whole run weighs at most
    /// first_weight / (1 - decay) observations, since it mostly says the same thing again and again.
    pub decay: f64,
    /// How often a landmark that should be seen is hidden, 0 to 1: for an observation without a landmark, this share of the
    /// likelihood is the same for all states.
    pub hidden: f64,
    /// Share of the belief that goes back to all states alike with each action, 0 to 1.
    pub floor: f64,
}

impl Remedy {
    /// None: as published.
    #[must_use]
    pub fn none() -> Self {
        Self { first_weight: 1.0, decay: 1.0, hidden: 0.0, floor: 0.0 }
    }

    fn check(&self) -> Result<(), ConfigError> {
        for (key, value) in [
            ("remedy.first_weight", self.first_weight),
            ("remedy.decay", self.decay),
            ("remedy.hidden", self.hidden),
            ("remedy.floor", self.floor),
        ] {
            require((0.0..=1.0).contains(&value), key, "0 to 1", value)?;
        }
        Ok(())
    }
}

impl Default for Remedy {
    fn default() -> Self {
        Self { first_weight: 0.5, decay: 0.5, hidden: 0.3, floor: 0.002 }
    }
}

/// Where the robot starts, if that is known, and what is kept when it is lifted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct KnownStart {
    /// Whether it is known.
    pub is_known: bool,
    /// Position in the map, meters.
    #[schemars(extend("x-only-if" = "is_known = true"))]
    pub x_m: f64,
    /// Position in the map, meters.
    #[schemars(extend("x-only-if" = "is_known = true"))]
    pub y_m: f64,
    /// Heading in the map, degrees.
    #[schemars(extend("x-only-if" = "is_known = true"))]
    pub yaw_deg: f64,
    /// Probability of the state there, or of all states of a start prior together. Source: section 4.3, 0.8.
    pub probability: f64,
    /// After a lift, this share of the belief is put around the last pose that could be relied on, 0 to 1: somebody may
    /// have set the robot back. 0 forgets it.
    pub keep_old_pose_share: f64,
    /// Spread around that pose, meters.
    #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
    pub old_pose_spread_m: f64,
    /// Spread around its heading, degrees.
    #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
    pub old_pose_spread_deg: f64,
}

impl Default for KnownStart {
    fn default() -> Self {
        Self {
            is_known: false,
            x_m: 0.0,
            y_m: 0.0,
            yaw_deg: 0.0,
            probability: 0.8,
            keep_old_pose_share: 0.0,
            old_pose_spread_m: 0.3,
            old_pose_spread_deg: 17.0,
        }
    }
}

/// How seen landmarks are compared with those that a state expects.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExpectedViewConfig {
    /// Poses spread over each state that stand for it. The source takes 50 captures in each state.
    pub samples_per_state: usize,
    /// Share of the landmarks in view that are detected.
    pub detection: f64,
    /// A visible area at which half of that is detected, pixels of an image 320 pixels wide.
    pub weak_area_px: f64,
    /// Probability of seeing a landmark where none is.
    pub false_alarm: f64,
    /// Standard deviation of the bearing of the centroid, degrees.
    pub bearing_sigma_deg: f64,
    /// Standard deviation of the logarithm of the area.
    pub log_area_sigma: f64,
    /// Share of detections that can be anything, for instance half hidden.
    pub outlier: f64,
    /// An image is taken for new evidence if the robot acted, or the camera turned by this, degrees.
    pub new_view_deg: f64,
    /// Power to which the likelihood of an image is raised, 0 to 1: images share their errors.
    pub weight: f64,
}

impl Default for ExpectedViewConfig {
    fn default() -> Self {
        Self {
            samples_per_state: 18,
            detection: 0.9,
            weak_area_px: 80.0,
            false_alarm: 0.02,
            bearing_sigma_deg: 4.0,
            log_area_sigma: 0.35,
            outlier: 0.1,
            new_view_deg: 12.0,
            weight: 0.7,
        }
    }
}

impl ExpectedViewConfig {
    fn check(&self) -> Result<(), ConfigError> {
        let samples = self.samples_per_state;
        require((1..=1000).contains(&samples), "view.samples_per_state", "1 to 1000", samples)?;
        for (key, value) in [
            ("view.detection", self.detection),
            ("view.false_alarm", self.false_alarm),
            ("view.outlier", self.outlier),
        ] {
            require(value > 0.0 && value < 1.0, key, "above 0 and below 1", value)?;
        }
        for (key, value) in [
            ("view.weak_area_px", self.weak_area_px),
            ("view.bearing_sigma_deg", self.bearing_sigma_deg),
            ("view.log_area_sigma", self.log_area_sigma),
        ] {
            require(value > 0.0 && value <= 1e4, key, "above 0, at most 10000", value)?;
        }
        require(
            (0.0..=360.0).contains(&self.new_view_deg),
            "view.new_view_deg",
            "0 to 360",
            self.new_view_deg,
        )?;
        require(self.weight > 0.0 && self.weight <= 1.0, "view.weight", "above 0, at most 1", self.weight)
    }
}

/// Parameters of Markov localization.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MarkovConfig {
    /// Side of a tile, meters. Source: section 4.1, 0.5.
    pub tile_m: f64,
    /// Headings of each tile. Source: section 4.1, 4; 8 is its future work.
    pub num_headings: usize,
    /// Carpet at the border of the map that has no tiles, meters. Source: tiles cover the field up to its lines.
    pub border_m: f64,
    /// Whether the answer is the middle of the most probable state, as published, or the mean of the belief around it.
    pub is_mean: bool,
    /// Whether a robot between two tiles counts as localized: the belief of the states that touch the most probable one
    /// is added to it. The source looks at one state alone.
    pub counts_neighbors: bool,
    /// While images show nothing, the reliability falls to 37 % (1/e) in this time, seconds. The source keeps it.
    pub blind_secs: f64,
    /// The start.
    pub start: KnownStart,
    /// What comes of an action.
    pub outcomes: Outcomes,
    /// Against runs of observations without a landmark.
    pub remedy: Remedy,
    /// Comparison of what is seen with what a state expects.
    pub view: ExpectedViewConfig,
    /// Motion model: correction and limits of the odometry.
    pub motion: MotionConfig,
}

impl Default for MarkovConfig {
    fn default() -> Self {
        Self {
            tile_m: 0.5,
            num_headings: 8,
            border_m: 0.7,
            is_mean: true,
            counts_neighbors: true,
            blind_secs: 30.0,
            start: KnownStart::default(),
            outcomes: Outcomes::default(),
            remedy: Remedy::default(),
            view: ExpectedViewConfig::default(),
            motion: MotionConfig::default(),
        }
    }
}

impl MarkovConfig {
    /// The grid, decision and answer of the source: 4 headings, one state above 0.5, the middle of its tile.
    #[must_use]
    pub fn published() -> Self {
        Self { num_headings: 4, is_mean: false, counts_neighbors: false, ..Self::default() }
    }

    /// Checks the ranges of all values.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        require((0.05..=10.0).contains(&self.tile_m), "tile_m", "0.05 to 10", self.tile_m)?;
        require((1..=360).contains(&self.num_headings), "num_headings", "1 to 360", self.num_headings)?;
        require((0.0..=100.0).contains(&self.border_m), "border_m", "0 to 100", self.border_m)?;
        let secs = self.blind_secs;
        require(secs > 0.0 && secs <= 1e6, "blind_secs", "above 0, at most 1000000", secs)?;
        let start = &self.start;
        let is_place = [start.x_m, start.y_m, start.yaw_deg].iter().all(|v| v.is_finite());
        require(is_place, "start", "finite numbers", format!("{start:?}"))?;
        let known = start.probability;
        require(known > 0.0 && known <= 1.0, "start.probability", "above 0, at most 1", known)?;
        let kept = start.keep_old_pose_share;
        require((0.0..=1.0).contains(&kept), "start.keep_old_pose_share", "0 to 1", kept)?;
        for (key, value) in [
            ("start.old_pose_spread_m", start.old_pose_spread_m),
            ("start.old_pose_spread_deg", start.old_pose_spread_deg),
        ] {
            require((0.0..=360.0).contains(&value), key, "0 to 360", value)?;
        }
        self.outcomes.check()?;
        self.remedy.check()?;
        self.view.check()?;
        self.motion.check()
    }
}
