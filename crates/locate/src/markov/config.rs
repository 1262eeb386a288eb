//! Parameters of Markov localization.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use super::Outcomes;
use crate::{ConfigError, MotionConfig};

visloc_core::with_defaults! {
    /// What is done against runs of observations without a landmark. The source names the trouble as open work: such
    /// observations raise the belief of many states, and the robot recovers slowly afterwards.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Remedy {
        /// Weight of the first observation of a run, 0 to 1: the power to which its likelihood is raised.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub first_weight: f64 = 0.5,
        /// Each further one weighs this share of the one before, 0 to 1. A whole run weighs at most
        /// first_weight / (1 - decay) observations, since it mostly says the same thing again and again.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub decay: f64 = 0.5,
        /// How often a landmark that should be seen is hidden, 0 to 1: for an observation without a landmark, this share of the
        /// likelihood is the same for all states.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub hidden: f64 = 0.3,
        /// Share of the belief that goes back to all states alike with each action, 0 to 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub floor: f64 = 0.002,
    }
}

impl Remedy {
    /// None: as published.
    pub fn none() -> Self {
        Self { first_weight: 1.0, decay: 1.0, hidden: 0.0, floor: 0.0 }
    }
}

visloc_core::with_defaults! {
    /// Where the robot starts, if that is known, and what is kept when it is lifted.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct KnownStart {
        /// Whether it is known.
        pub is_known: bool = false,
        /// Position in the map, meters.
        #[schemars(extend("x-only-if" = "is_known = true"))]
        #[schemars(range(min = -1000000.0, max = 1000000.0))]
        pub x_m: f64 = 0.0,
        /// Position in the map, meters.
        #[schemars(extend("x-only-if" = "is_known = true"))]
        #[schemars(range(min = -1000000.0, max = 1000000.0))]
        pub y_m: f64 = 0.0,
        /// Heading in the map, degrees.
        #[schemars(extend("x-only-if" = "is_known = true"))]
        #[schemars(range(min = -1000000.0, max = 1000000.0))]
        pub yaw_deg: f64 = 0.0,
        /// Probability of the state there, or of all states of a start prior together. Source: section 4.3, 0.8.
        #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
        pub probability: f64 = 0.8,
        /// After a lift, this share of the belief is put around the last pose that could be relied on, 0 to 1: somebody may
        /// have set the robot back. 0 forgets it.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub keep_old_pose_share: f64 = 0.0,
        /// Spread around that pose, meters.
        #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
        #[schemars(range(min = 0.0, max = 360.0))]
        pub old_pose_spread_m: f64 = 0.3,
        /// Spread around its heading, degrees.
        #[schemars(extend("x-only-if" = "keep_old_pose_share > 0"))]
        #[schemars(range(min = 0.0, max = 360.0))]
        pub old_pose_spread_deg: f64 = 17.0,
    }
}

visloc_core::with_defaults! {
    /// How seen landmarks are compared with those that a state expects.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct ExpectedViewConfig {
        /// Poses spread over each state that stand for it. The source takes 50 captures in each state.
        #[schemars(range(min = 1, max = 1000))]
        pub samples_per_state: usize = 18,
        /// Share of the landmarks in view that are detected.
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
        pub detection: f64 = 0.9,
        /// A visible area at which half of that is detected, pixels of an image 320 pixels wide.
        #[schemars(range(max = 10000.0), extend("exclusiveMinimum" = 0.0))]
        pub weak_area_px: f64 = 80.0,
        /// Probability of seeing a landmark where none is.
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
        pub false_alarm: f64 = 0.02,
        /// Standard deviation of the bearing of the centroid, degrees.
        #[schemars(range(max = 10000.0), extend("exclusiveMinimum" = 0.0))]
        pub bearing_sigma_deg: f64 = 4.0,
        /// Standard deviation of the logarithm of the area.
        #[schemars(range(max = 10000.0), extend("exclusiveMinimum" = 0.0))]
        pub log_area_sigma: f64 = 0.35,
        /// Share of detections that can be anything, for instance half hidden.
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
        pub outlier: f64 = 0.1,
        /// An image is taken for new evidence if the robot acted, or the camera turned by this, degrees.
        #[schemars(range(min = 0.0, max = 360.0))]
        pub new_view_deg: f64 = 12.0,
        /// Power to which the likelihood of an image is raised, 0 to 1: images share their errors.
        #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
        pub weight: f64 = 0.7,
    }
}

visloc_core::with_defaults! {
    /// Parameters of Markov localization.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct MarkovConfig {
        /// Side of a tile, meters. Source: section 4.1, 0.5.
        #[schemars(range(min = 0.05, max = 10.0))]
        pub tile_m: f64 = 0.5,
        /// Headings of each tile. Source: section 4.1, 4; 8 is its future work.
        #[schemars(range(min = 1, max = 360))]
        pub num_headings: usize = 8,
        /// Carpet at the border of the map that has no tiles, meters. Source: tiles cover the field up to its lines.
        #[schemars(range(min = 0.0, max = 100.0))]
        pub border_m: f64 = 0.7,
        /// Whether the answer is the middle of the most probable state, as published, or the mean of the belief around it.
        pub is_mean: bool = true,
        /// Whether a robot between two tiles counts as localized: the belief of the states that touch the most probable one
        /// is added to it. The source looks at one state alone.
        pub counts_neighbors: bool = true,
        /// While images show nothing, the reliability falls to 37 % (1/e) in this time, seconds. The source keeps it.
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        pub blind_secs: f64 = 30.0,
        /// The start.
        pub start: KnownStart = KnownStart::default(),
        /// What comes of an action.
        pub outcomes: Outcomes = Outcomes::default(),
        /// Against runs of observations without a landmark.
        pub remedy: Remedy = Remedy::default(),
        /// Comparison of what is seen with what a state expects.
        pub view: ExpectedViewConfig = ExpectedViewConfig::default(),
        /// Motion model: correction and limits of the odometry.
        pub motion: MotionConfig = MotionConfig::default(),
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
