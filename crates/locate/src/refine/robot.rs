//! What is known of the robot wherever it is.

use super::{RefinementConfig, filter::PoseFilter, mount::Mount};

/// What tracks that were known to be right have found out about the robot: it holds wherever that is put next.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownRobot {
    /// The filter of the last one.
    pub filter: Option<PoseFilter>,
    /// The constant error of its camera; every new track begins with it.
    pub mount: Mount,
}

impl KnownRobot {
    /// What the camera that a track needs speaks against it: that few robots have such a one, and where places look alike also that it is
    /// not the robot's camera.
    pub fn bend(&self, filter: &PoseFilter, config: &RefinementConfig) -> f64 {
        let slow = if config.has_look_alikes {
            filter.bend(self.filter.as_ref(), config).min(config.max_bend_evidence)
        } else {
            0.0
        };
        slow + self.mount.surprise(&filter.mount().tilt_rad, config)
    }
}
