//! Parameters of Markov localization.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use super::Outcomes;
use crate::{ConfigError, MotionConfig};

/// What is done against runs of observations without a landmark. The source names the trouble as open work: such
/// observations raise the belief of many states, and the robot recovers slowly afterwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Remedy {
    /// Weight of the first observation of a run, 0 to 1: the power to which its likelihood is raised.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub first_weight: f64,
    /// Each further one weighs this share of the one before, 0 to 1. A whole run weighs at most
    /// first_weight / (1 - decay) observations, since it mostly says the same thing again and again.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub decay: f64,
    /// How often a landmark that should be seen is hidden, 0 to 1: for an observation without a landmark, this share of the
    /// likelihood is the same for all states.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub hidden: f64,
    /// Share of the belief that goes back to all states alike with each action, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub floor: f64,
}

impl Remedy {
    /// None: as published.
    pub fn none() -> Self {
        Self { first_weight: 1.0, decay: 1.0, hidden: 0.0, floor: 0.0 }
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
    #[schemars(range(min = -1000000.0, max = 1000000.0))]
    pub x_m: f64,
    /// Position in the map, meters.
    #[schemars(extend("x-only-if" = "is_known = true"))]
    #[schemars(range(min = -1000000.0, max = 1000000.0))]
    pub y_m: f64,
    /// Heading in the map, degrees.
    #[schemars(extend("x-only-if" = "is_known = true"))]
    #[schemars(range(min = -1000000.0, max = 1000000.0))]
    pub yaw_deg: f64,
    /// Probability of the state there, or of all states of a start prior together. Source: section 4.3, 0.8.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub probability: f64,
    /// After a lift, this share of the belief is put around the last pose that could be relied on, 0 to 1: somebody may
    /// have set the robot back. 0 forgets it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub keep_old_pose_share: f64,
    /// Spread around that pose, meters.
    #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
    #[schemars(range(min = 0.0, max = 360.0))]
    pub old_pose_spread_m: f64,
    /// Spread around its heading, degrees.
    #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
    #[schemars(range(min = 0.0, max = 360.0))]
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
    #[schemars(range(min = 1, max = 1000))]
    pub samples_per_state: usize,
    /// Share of the landmarks in view that are detected.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub detection: f64,
    /// A visible area at which half of that is detected, pixels of an image 320 pixels wide.
    #[schemars(range(max = 10000.0), extend("exclusiveMinimum" = 0.0))]
    pub weak_area_px: f64,
    /// Probability of seeing a landmark where none is.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub false_alarm: f64,
    /// Standard deviation of the bearing of the centroid, degrees.
    #[schemars(range(max = 10000.0), extend("exclusiveMinimum" = 0.0))]
    pub bearing_sigma_deg: f64,
    /// Standard deviation of the logarithm of the area.
    #[schemars(range(max = 10000.0), extend("exclusiveMinimum" = 0.0))]
    pub log_area_sigma: f64,
    /// Share of detections that can be anything, for instance half hidden.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub outlier: f64,
    /// An image is taken for new evidence if the robot acted, or the camera turned by this, degrees.
    #[schemars(range(min = 0.0, max = 360.0))]
    pub new_view_deg: f64,
    /// Power to which the likelihood of an image is raised, 0 to 1: images share their errors.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
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

/// Parameters of Markov localization.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MarkovConfig {
    /// Side of a tile, meters. Source: section 4.1, 0.5.
    #[schemars(range(min = 0.05, max = 10.0))]
    pub tile_m: f64,
    /// Headings of each tile. Source: section 4.1, 4; 8 is its future work.
    #[schemars(range(min = 1, max = 360))]
    pub num_headings: usize,
    /// Carpet at the border of the map that has no tiles, meters. Source: tiles cover the field up to its lines.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub border_m: f64,
    /// Whether the answer is the middle of the most probable state, as published, or the mean of the belief around it.
    pub is_mean: bool,
    /// Whether a robot between two tiles counts as localized: the belief of the states that touch the most probable one
    /// is added to it. The source looks at one state alone.
    pub counts_neighbors: bool,
    /// While images show nothing, the reliability falls to 37 % (1/e) in this time, seconds. The source keeps it.
    #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
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
    pub fn published() -> Self {
        Self { num_headings: 4, is_mean: false, counts_neighbors: false, ..Self::default() }
    }

    /// Checks the ranges of all values, and those that must go together.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        self.outcomes.check()?;
        self.motion.check()
    }
}
