//! Parameters of a team.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{ConfigError, require};

/// What is known of robots that tell each other what they see.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TeamConfig {
    /// Messages a second.
    pub messages_per_sec: f64,
    /// A robot that has been silent for so long has left, seconds.
    pub silence_secs: f64,
    /// Probability that a detector sees a robot or ball that is in view.
    pub detection: f64,
    /// False sightings for each image.
    pub false_per_image: f64,
    /// Sightings within this time resemble each other: together they count as one, seconds.
    pub correlation_secs: f64,
    /// What sightings have told of who is where falls to one half in this time, seconds.
    pub forget_secs: f64,
    /// Probability that a robot is not wrong about the half that it is sure of, nor lies.
    pub honesty: f64,
    /// Probability of a half from which on it counts as decided.
    pub decided: f64,
    /// How fast robots move where their motion is not known, meters per second.
    pub robot_m_per_s: f64,
    /// How fast the ball moves, meters per second.
    pub ball_m_per_s: f64,
    /// By how much the time between two robots' clocks may be wrong, seconds.
    pub clock_secs: f64,
}

impl Default for TeamConfig {
    fn default() -> Self {
        Self {
            messages_per_sec: 5.0,
            silence_secs: 3.0,
            detection: 0.8,
            false_per_image: 0.05,
            correlation_secs: 1.0,
            forget_secs: 30.0,
            honesty: 0.9,
            decided: 0.9,
            robot_m_per_s: 0.3,
            ball_m_per_s: 0.5,
            clock_secs: 0.1,
        }
    }
}

impl TeamConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        for (key, value, least, most) in [
            ("team.messages_per_sec", self.messages_per_sec, 0.1, 30.0),
            ("team.silence_secs", self.silence_secs, 0.1, 60.0),
            ("team.false_per_image", self.false_per_image, 1e-6, 10.0),
            ("team.correlation_secs", self.correlation_secs, 0.01, 60.0),
            ("team.forget_secs", self.forget_secs, 0.1, 1e6),
            ("team.robot_m_per_s", self.robot_m_per_s, 0.0, 20.0),
            ("team.ball_m_per_s", self.ball_m_per_s, 0.0, 50.0),
            ("team.clock_secs", self.clock_secs, 0.0, 5.0),
        ] {
            require((least..=most).contains(&value), key, "a value within its range", value)?;
        }
        for (key, value) in [
            ("team.detection", self.detection),
            ("team.honesty", self.honesty),
            ("team.decided", self.decided),
        ] {
            require(value > 0.5 && value < 1.0, key, "above 0.5 and below 1", value)?;
        }
        Ok(())
    }
}
