//! Thresholds of the comparison.

use serde::{Deserialize, Serialize};

crate::with_defaults! {
    /// Thresholds of the comparison. The defaults are those of all published numbers.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct EvaluationOptions {
        /// Above this reliability, in [0, 1], an estimate claims to know where the robot is.
        pub min_reliability: f64 = 0.6,
        /// Largest difference of stamps between an estimate and its truth, seconds.
        pub stamp_tolerance_secs: f64 = 0.02,
        /// Up to this height above the ground the robot stands on it, meters.
        pub max_ground_height_m: f64 = 0.02,
        /// Faster than this the robot does not walk, meters per second.
        pub max_walking_speed_m_per_s: f64 = 0.8,
        /// A fast motion that covers less than this, meters, is noise of the truth.
        pub min_carried_distance_m: f64 = 0.2,
        /// Carried spans that are closer than this are one, seconds.
        pub max_carried_gap_secs: f64 = 0.5,
        /// After a kidnap, the robot has found itself if it is closer to the truth than this, meters.
        pub max_recovered_error_m: f64 = 0.5,
        /// The same for the heading, degrees.
        pub max_recovered_error_deg: f64 = 20.0,
        /// How long it must stay so, seconds.
        pub min_recovered_secs: f64 = 1.0,
    }
}
