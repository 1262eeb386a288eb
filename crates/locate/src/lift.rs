//! Finds out from the feet that the robot was lifted or has fallen.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::{GroundContact, Timestamp};

visloc_core::with_defaults! {
    /// Parameters of the lift detector. Source: 2010 section 3.10: all sensors near zero for a configurable time.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct LiftConfig {
        /// A sensor below this force carries nothing, newtons.
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        pub max_unloaded_n: f64 = 1.0,
        /// The feet must be unloaded for this long, seconds.
        #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 60.0))]
        pub min_unloaded_secs: f64 = 0.1,
    }
}

/// Watches the feet.
#[derive(Debug, Clone)]
pub struct LiftDetector {
    config: LiftConfig,
    unloaded_since: Option<Timestamp>,
}

impl LiftDetector {
    /// A detector that has seen nothing yet.
    pub fn new(config: LiftConfig) -> Self {
        Self { config, unloaded_since: None }
    }

    /// Takes in one reading; returns whether the robot is off the ground. Without a reading it is taken to stand.
    pub fn update(&mut self, at: Timestamp, contact: Option<&GroundContact>) -> bool {
        let is_unloaded = match contact {
            None => false,
            Some(GroundContact::Contact(on_ground)) => !on_ground,
            Some(GroundContact::Pressure(newtons)) => {
                newtons.iter().all(|force| force.abs() < self.config.max_unloaded_n)
            }
        };
        if !is_unloaded {
            self.unloaded_since = None;
            return false;
        }
        let since = *self.unloaded_since.get_or_insert(at);
        at.secs_since(since) >= self.config.min_unloaded_secs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: f64) -> Timestamp {
        Timestamp::from_secs(secs)
    }

    #[test]
    fn all_sensors_near_zero_for_long_enough() {
        let config = LiftConfig { max_unloaded_n: 1.0, min_unloaded_secs: 0.2 };
        let mut detector = LiftDetector::new(config);
        let standing = GroundContact::Pressure([6.0; 8]);
        let lifted = GroundContact::Pressure([0.1, -0.2, 0.0, 0.3, 0.0, 0.1, 0.0, 0.2]);
        let one_foot = GroundContact::Pressure([0.0, 0.0, 0.0, 0.0, 12.0, 11.0, 12.0, 10.0]);
        assert!(!detector.update(at(0.0), Some(&standing)));
        assert!(!detector.update(at(0.1), Some(&lifted)));
        assert!(!detector.update(at(0.2), Some(&lifted)), "not yet long enough");
        assert!(detector.update(at(0.31), Some(&lifted)));
        assert!(!detector.update(at(0.4), Some(&one_foot)), "one foot on the ground");
        assert!(!detector.update(at(0.5), Some(&lifted)), "the time starts anew");
        assert!(!detector.update(at(0.9), None));
    }

    #[test]
    fn a_robot_that_reports_contact_itself() {
        let mut detector = LiftDetector::new(LiftConfig { min_unloaded_secs: 0.0, ..LiftConfig::default() });
        assert!(detector.update(at(0.0), Some(&GroundContact::Contact(false))));
        assert!(!detector.update(at(0.1), Some(&GroundContact::Contact(true))));
    }
}
