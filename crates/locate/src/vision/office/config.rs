//! Parameters of the image analysis.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How straight edges are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SegmentDetector {
    /// Ridges of the brightness gradient, linked while their direction stays the same.
    Gradient,
    /// Contours of the Laplacian, cut into straight pieces: the method of the documents.
    Contour,
}

visloc_core::with_defaults! {
    /// Which filters are on.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct OfficeFilters {
        /// Edges of doors stand upright, borders of the floor do not.
        pub upright: bool = true,
        /// Short lines are dropped.
        pub short: bool = true,
        /// What lies above the horizon is dropped.
        pub horizon: bool = true,
        /// Only so many pixels are kept, chosen at random.
        pub random_discard: bool = true,
    }
}

visloc_core::with_defaults! {
    /// Parameters of the image analysis of a building. Pixels are those of an image 320 px wide; larger images scale them.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct OfficeAnalysisConfig {
        /// How straight edges are found.
        pub detector: SegmentDetector = SegmentDetector::Gradient,
        /// Least step of brightness across an edge, 0 to 255.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_step: f64 = 9.0,
        /// Shortest straight edge before lines are joined, pixels.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_segment_px: f64 = 7.0,
        /// Shortest line after lines are joined, pixels.
        #[schemars(extend("x-only-if" = "filters.short = true"))]
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_line_px: f64 = 11.0,
        /// Lines of one kind are joined over a gap of this size, pixels.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_gap_px: f64 = 8.0,
        /// A door's edge may lean by this much, degrees.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_lean_deg: f64 = 5.0,
        /// A border of the floor leans from the upright by at least this much, degrees: the sides of things that stand on the
        /// floor do not. A wall at the camera's height above the floor to one side leans by 45 degrees.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_floor_lean_deg: f64 = 15.0,
        /// Gray counts as wall beside the floor from this share of the floor's brightness on: darker things stand on the floor.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub min_wall_share: f64 = 0.43,
        /// Share of a new image in the running estimate of the light's color, 0 to 1; with 0 the light is taken for white.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub light_follow: f64 = 0.1,
        /// What is farther away than this is dropped, meters.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_distance_m: f64 = 12.0,
        /// Side of the cells of the grid at the horizon, pixels.
        #[schemars(range(min = 1.0, max = 1000.0))]
        pub min_cell_px: f64 = 4.0,
        /// Side of the cells at the lower border of the image, pixels.
        #[schemars(range(min = 1.0, max = 1000.0))]
        pub max_cell_px: f64 = 16.0,
        /// Most pixels of doors.
        #[schemars(extend("x-only-if" = "filters.random_discard = true"))]
        #[schemars(range(min = 1, max = 1_000_000))]
        pub max_door_pixels: usize = 40,
        /// Most pixels of the floor's border.
        #[schemars(extend("x-only-if" = "filters.random_discard = true"))]
        #[schemars(range(min = 1, max = 1_000_000))]
        pub max_floor_pixels: usize = 40,
        /// From so many pixels of doors on an image has full quality.
        #[schemars(range(min = 1, max = 1_000_000))]
        pub full_quality_pixels: usize = 16,
        /// Which filters are on.
        pub filters: OfficeFilters = OfficeFilters::default(),
    }
}
