//! Parameters of the analysis.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use super::features::FeatureDetectionConfig;
use crate::{
    ConfigError, require,
    vision::color::{ColorConfig, GoalColors},
};

visloc_core::with_defaults! {
    /// Which filters run. The documents switch each one on.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct FilterSwitches {
        /// A line has carpet on both sides.
        pub beside_carpet: bool = true,
        /// A line is as thick as its distance demands.
        pub too_thin: bool = true,
        /// A goal's border runs upright or lies above the horizon.
        pub post_or_bar: bool = true,
        /// Enough neighbors of the same color.
        pub isolated: bool = true,
        /// Lines not too far away.
        pub horizon: bool = true,
        /// Not the robot's own body.
        pub own_body: bool = true,
        /// Lines below the end of the carpet.
        pub field_end: bool = true,
        /// Goals inside of valid blobs.
        pub goal_blobs: bool = true,
        /// Not inside of obstacles.
        pub obstacles: bool = true,
        /// A bounded number of pixels, taken at random.
        pub random_discard: bool = true,
    }
}

visloc_core::with_defaults! {
    /// Parameters of the analysis of a field image. Pixel values are for images 320 px wide and scale with the width.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    #[schemars(extend("x-no-keys" = {
        "line_width_m": "the map says how wide lines are",
        "goal_height_m": "the map says how high goals are",
        "goal_colors": "the map says which color goals have",
        "ball_diameter_m": "the map says how large the ball is",
    }))]
    pub struct FieldAnalysisConfig {
        /// Color classes.
        pub colors: ColorConfig = ColorConfig::default(),
        /// Which filters run.
        pub filters: FilterSwitches = FilterSwitches::default(),
        /// Distance of the vertical scan lines, pixels; in the far part of the image there are twice as many.
        #[schemars(range(min = 1, max = 100))]
        pub column_step_px: u32 = 8,
        /// Distance of the horizontal scan lines at the horizon, pixels; grows towards the bottom.
        #[schemars(range(min = 1, max = 100))]
        pub min_row_step_px: u32 = 3,
        /// Distance of the horizontal scan lines at the bottom and above the horizon, pixels.
        #[schemars(range(min = 1, max = 100))]
        pub max_row_step_px: u32 = 10,
        /// Width of the field's lines, meters. No key: the map says it.
        #[serde(skip)]
        pub line_width_m: f64 = 0.05,
        /// A run is too thin for a line below this share of the thickness that its distance demands.
        #[schemars(extend("x-only-if" = "filters.too_thin = true"))]
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_thickness_share: f64 = 0.8,
        /// A goal's border is upright if it moves sideways by at most this many pixels a row.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_post_slope: f64 = 0.35,
        /// Of the eight pixels around one, this many must have its color; with learned colors, lines thinner than three pixels go on to both
        /// sides instead. Source: 2010 section 4.2, 3.
        #[schemars(extend("x-only-if" = "filters.isolated = true"))]
        #[schemars(range(min = 0, max = 8))]
        pub min_neighbors: u32 = 3,
        /// Line pixels farther away than this are dropped, meters; on fields longer than 6 m in proportion farther. Source: 2010 section
        /// 4.2, 6 m.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_line_distance_m: f64 = 6.0,
        /// Pixels nearer than this are dropped, meters. Source: 2010 section 4.2, 15 cm.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub own_body_distance_m: f64 = 0.15,
        /// Columns in which the end of the field is looked for, pixels. Source: 2010 section 4.2, 10.
        #[schemars(range(min = 1, max = 100))]
        pub field_end_step_px: u32 = 10,
        /// Least height of a goal blob, pixels.
        pub min_blob_height_px: u32 = 12,
        /// Height of the goals, to the middle of the crossbar, meters. No key: the map says it.
        #[serde(skip)]
        pub goal_height_m: f64 = 0.85,
        /// Which colored goals there are, for learned colors. No key: the map says it.
        #[serde(skip)]
        pub goal_colors: GoalColors = GoalColors::default(),
        /// A filled blob that is more than this many times as wide as high is a board, not a goal.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_filled_blob_aspect: f64 = 1.2,
        /// Least height of the white segments that obstacles are made of, meters, taken as standing upright.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_obstacle_height_m: f64 = 0.15,
        /// Least width of an obstacle, meters.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_obstacle_width_m: f64 = 0.12,
        /// So many line pixels make an image informative without any goal; 0 for never. If it is not set, never on a field with colored
        /// goals (source: 2010 section 5.2.1), and 10 on one without, which has nothing else.
        pub min_informative_lines: Option<usize> = None,
        /// How many line pixels are kept. Source: 2010 section 4.3.2, 12.
        #[schemars(range(min = 1, max = 1_000_000))]
        pub max_line_pixels: usize = 12,
        /// How many goal pixels are kept. Source: 2010 section 4.3.2, 8.
        #[schemars(range(min = 1, max = 1_000_000))]
        pub max_goal_pixels: usize = 8,
        /// How many line pixels the refinement of the pose gets; 0 for none.
        pub max_line_borders: usize = 120,
        /// How many goal pixels the refinement of the pose gets; 0 for none.
        pub max_goal_borders: usize = 60,
        /// Composite features.
        pub composite: FeatureDetectionConfig = FeatureDetectionConfig::default(),
        /// Whether robots and balls are detected, five times a second at most, for teams. It changes nothing else.
        pub detect_objects: bool = false,
        /// Diameter of the ball, meters. No key: the map says it.
        #[serde(skip)]
        pub ball_diameter_m: f64 = 0.1,
    }
}

impl FieldAnalysisConfig {
    /// Checks the ranges of all values, and those that the map says.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        self.colors.check()?;
        let lengths = [
            ("line_width_m", self.line_width_m),
            ("goal_height_m", self.goal_height_m),
            ("ball_diameter_m", self.ball_diameter_m),
        ];
        for (key, found) in lengths.into_iter().chain(self.composite.lengths()) {
            require(found > 0.0 && found.is_finite(), key, "a number above 0", found)?;
        }
        Ok(())
    }
}
