//! Parameters of the composite features.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

visloc_core::with_defaults! {
    /// What the detectors of composite features must know of the field.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    #[schemars(extend("x-no-keys" = {
        "circle_radius_m": "the map says how large the circle is",
        "mark_size_m": "the map says how large penalty marks are",
        "post_diameter_m": "the map says how thick goal posts are",
        "has_white_goals": "the map says which color goals have",
    }))]
    pub struct FeatureDetectionConfig {
        /// Whether composite features are looked for.
        pub is_on: bool = true,
        /// Radius of the center line of the center circle, meters. No key, as all that follows: the map says it.
        #[serde(skip)]
        pub circle_radius_m: f64 = 0.6,
        /// Length of the bars of a penalty mark, meters.
        #[serde(skip)]
        pub mark_size_m: f64 = 0.1,
        /// Diameter of goal posts, meters.
        #[serde(skip)]
        pub post_diameter_m: f64 = 0.1,
        /// Whether goals are white.
        #[serde(skip)]
        pub has_white_goals: bool = false,
    }
}

impl FeatureDetectionConfig {
    /// The lengths with their keys, for the check of their ranges.
    pub(in crate::vision::field) fn lengths(&self) -> [(&'static str, f64); 3] {
        [
            ("composite.circle_radius_m", self.circle_radius_m),
            ("composite.mark_size_m", self.mark_size_m),
            ("composite.post_diameter_m", self.post_diameter_m),
        ]
    }
}
