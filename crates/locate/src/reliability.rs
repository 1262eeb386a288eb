//! How far the estimate can be trusted: a value that follows quality and likelihood slowly.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{ConfigError, require};

/// Thresholds and steps of the reliability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ReliabilityConfig {
    /// Likelihood above which the reliability grows (`P_max`).
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub high_likelihood: f64,
    /// Likelihood below which it shrinks (`P_min`).
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub low_likelihood: f64,
    /// Quality above which an image counts as good.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub high_quality: f64,
    /// Quality below which an image changes nothing, unless it does not fit: then it counts as one that shows nothing.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub low_quality: f64,
    /// Largest change by a good image.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub max_step: f64,
    /// Largest change by a poor image.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub min_step: f64,
    /// While images show nothing, the reliability falls to 37 % (1/e) in this time, seconds; of tracks up to a hundred times as fast where lines
    /// should be seen. The documents keep it.
    #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
    pub blind_secs: f64,
}

impl ReliabilityConfig {
    /// The thresholds of the master's thesis, section 5.1.3.
    pub fn published_2010() -> Self {
        Self {
            high_likelihood: 0.8,
            low_likelihood: 0.7,
            high_quality: 0.6,
            low_quality: 0.3,
            max_step: 0.15,
            min_step: 0.03,
            blind_secs: 30.0,
        }
    }

    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let low = self.low_likelihood;
        require(low <= self.high_likelihood, "reliability.low_likelihood", "at most high_likelihood", low)
    }
}

impl Default for ReliabilityConfig {
    fn default() -> Self {
        Self::published_2010()
    }
}

/// The reliability of an estimate, 0 at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reliability {
    config: ReliabilityConfig,
    value: f64,
}

impl Reliability {
    /// Starts at 0.
    pub fn new(config: ReliabilityConfig) -> Self {
        Self { config, value: 0.0 }
    }

    /// The reliability, 0 to 1.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Back to 0.
    pub fn reset(&mut self) {
        self.value = 0.0;
    }

    /// Follows one image of the given quality whose likelihood at the estimate is given, so many seconds after the last one. Equations
    /// 4.5 to 4.8 (2017). Deviation: they keep the reliability for ever while images are too poor to count.
    pub fn update(&mut self, likelihood: f64, quality: f64, secs: f64) {
        let c = &self.config;
        if quality < c.low_quality {
            if likelihood < c.low_likelihood {
                self.fade(secs);
            }
            return;
        }
        let step = if quality > c.high_quality { c.max_step } else { c.min_step };
        if likelihood > c.high_likelihood {
            self.value += step * (likelihood - c.high_likelihood) / (1.0 - c.high_likelihood);
        } else if likelihood < c.low_likelihood {
            self.value -= step * (c.low_likelihood - likelihood) / c.low_likelihood;
        }
        self.value = self.value.clamp(0.0, 1.0);
    }

    /// Images have shown nothing for so long: somebody may have moved the robot. A robot that counts as sure (1) is not localized any
    /// more after half of `blind_secs`.
    pub fn fade(&mut self, secs: f64) {
        self.value *= blind_share(secs, self.config.blind_secs);
    }

    /// A part of the way to another reliability; `share` is 0 to 1.
    #[must_use]
    pub fn toward(&self, other: &Self, share: f64) -> Self {
        Self { value: self.value + share * (other.value - self.value), ..*self }
    }

    /// The estimate jumped by this distance: the reliability shrinks, to 0 at `max_distance_m`. Equation 4.9 (2017).
    pub fn jump(&mut self, distance_m: f64, max_distance_m: f64) {
        self.value *= (1.0 - distance_m / max_distance_m).max(0.0);
    }
}

/// What is left of a reliability after so long without anything in view.
pub(crate) fn blind_share(secs: f64, blind_secs: f64) -> f64 {
    (-secs / blind_secs).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_cases_of_2017_by_hand() {
        // The thresholds of the doctoral thesis, section 4.1.5. It does not say which quality is high; the limits are those of 2010.
        let config = ReliabilityConfig {
            high_likelihood: 0.7,
            low_likelihood: 0.5,
            ..ReliabilityConfig::published_2010()
        };
        let mut r = Reliability::new(config);
        r.update(0.85, 0.9, 0.1); // + 0.15 * 0.15 / 0.3
        assert!((r.value() - 0.075).abs() < 1e-12);
        r.update(1.0, 0.5, 0.1); // + 0.03
        assert!((r.value() - 0.105).abs() < 1e-12);
        r.update(0.25, 0.4, 0.1); // - 0.03 * 0.25 / 0.5
        assert!((r.value() - 0.09).abs() < 1e-12);
        r.update(0.4, 0.9, 0.1); // - 0.15 * 0.1 / 0.5
        assert!((r.value() - 0.06).abs() < 1e-12);
        r.update(0.6, 0.9, 0.1); // between the thresholds: unchanged
        r.update(1.0, 0.1, 0.1); // too poor an image: unchanged
        assert!((r.value() - 0.06).abs() < 1e-12);
    }

    #[test]
    fn the_cases_of_2010_by_hand() {
        let mut r = Reliability::new(ReliabilityConfig::published_2010());
        r.update(0.9, 0.7, 0.1); // + 0.15 * (0.2 - 0.1) / 0.2
        assert!((r.value() - 0.075).abs() < 1e-12);
        r.update(0.35, 0.5, 0.1); // - 0.03 * 0.35 / 0.7
        assert!((r.value() - 0.06).abs() < 1e-12);
    }

    #[test]
    fn fades_by_time_and_not_by_images() {
        for images in [1, 30, 900] {
            let mut r = Reliability { config: ReliabilityConfig::default(), value: 1.0 };
            (0..images).for_each(|_| r.fade(15.0 / f64::from(images)));
            assert!((r.value() - (-0.5_f64).exp()).abs() < 1e-9, "{}", r.value());
        }
    }

    #[test]
    fn stays_between_0_and_1_and_follows_jumps() {
        let mut r = Reliability::new(ReliabilityConfig::default());
        for _ in 0..100 {
            r.update(1.0, 1.0, 0.1);
        }
        assert!((r.value() - 1.0).abs() < 1e-12);
        r.jump(0.5, 2.0);
        assert!((r.value() - 0.75).abs() < 1e-12);
        r.jump(3.0, 2.0);
        assert!(r.value().abs() < 1e-12);
        r.update(0.0, 1.0, 0.1);
        assert!(r.value().abs() < 1e-12);
    }
}
