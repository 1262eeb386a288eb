//! Parameters of a team.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

visloc_core::with_defaults! {
    /// What is known of robots that tell each other what they see.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct TeamConfig {
        /// Messages a second.
        #[schemars(range(min = 0.1, max = 30.0))]
        pub messages_per_sec: f64 = 5.0,
        /// A robot that has been silent for so long has left, seconds.
        #[schemars(range(min = 0.1, max = 60.0))]
        pub silence_secs: f64 = 3.0,
        /// Probability that a detector sees a robot or ball that is in view.
        #[schemars(extend("exclusiveMinimum" = 0.5, "exclusiveMaximum" = 1.0))]
        pub detection: f64 = 0.8,
        /// False sightings for each image.
        #[schemars(range(min = 1e-6, max = 10.0))]
        pub false_per_image: f64 = 0.05,
        /// Sightings within this time resemble each other: together they count as one, seconds.
        #[schemars(range(min = 0.01, max = 60.0))]
        pub correlation_secs: f64 = 1.0,
        /// What sightings have told of who is where falls to one half in this time, seconds.
        #[schemars(range(min = 0.1, max = 1e6))]
        pub forget_secs: f64 = 30.0,
        /// Probability that a robot is not wrong about the half that it is sure of, nor lies.
        #[schemars(extend("exclusiveMinimum" = 0.5, "exclusiveMaximum" = 1.0))]
        pub honesty: f64 = 0.9,
        /// Probability of a half from which on it counts as decided.
        #[schemars(extend("exclusiveMinimum" = 0.5, "exclusiveMaximum" = 1.0))]
        pub decided: f64 = 0.9,
        /// How fast robots move where their motion is not known, meters per second.
        #[schemars(range(min = 0.0, max = 20.0))]
        pub robot_m_per_s: f64 = 0.3,
        /// How fast the ball moves, or the person whom all know, meters per second.
        #[schemars(range(min = 0.0, max = 50.0))]
        pub ball_m_per_s: f64 = 0.5,
        /// By how much the time between two robots' clocks may be wrong, seconds.
        #[schemars(range(min = 0.0, max = 5.0))]
        pub clock_secs: f64 = 0.1,
    }
}
