//! What is known of the robot wherever it is.

use super::{RefinementConfig, filter::PoseFilter, mount::Mount};
use crate::per_camera::OtherCameras;

/// What tracks that were known to be right have found out about the robot: it holds wherever that is put next.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownRobot {
    /// The filter of the last one.
    pub filter: Option<PoseFilter>,
    /// The constant error of the camera whose image it is; every new track begins with it.
    pub mount: Mount,
    /// Which camera that is.
    pub camera_index: usize,
    other_mounts: OtherCameras<Mount>,
}

impl KnownRobot {
    /// A robot of whose cameras nothing is known.
    pub fn unknown(config: &RefinementConfig) -> Self {
        Self { mount: Mount::unknown(config), ..Self::default() }
    }

    /// The next image is of this camera.
    pub fn look_through(&mut self, camera_index: usize, config: &RefinementConfig) {
        let cameras = (self.camera_index, camera_index);
        self.other_mounts.look_through(&mut self.mount, cameras, |_| Mount::unknown(config));
        self.camera_index = camera_index;
    }

    /// A filter that is known to be right.
    pub fn remember(&mut self, filter: &PoseFilter) {
        self.mount = filter.mount();
        filter.other_mounts().for_each(|(index, mount)| self.other_mounts.set(index, mount));
        self.filter = Some(filter.clone());
    }

    /// The robot has been lost for so long.
    pub fn doubt_mounts(&mut self, secs: f64, config: &RefinementConfig) {
        self.mount.relax(secs, config);
        self.other_mounts.values_mut().for_each(|mount| mount.relax(secs, config));
    }

    /// What is known of a camera.
    pub fn mount_of(&self, camera_index: usize) -> Option<&Mount> {
        if camera_index == self.camera_index {
            Some(&self.mount)
        } else {
            self.other_mounts.get(camera_index)
        }
    }

    /// What the cameras that a track needs speak against it: that few robots have such ones, and where places look alike also that they are
    /// not the robot's cameras.
    pub fn bend(&self, filter: &PoseFilter, config: &RefinementConfig) -> f64 {
        let slow = if config.has_look_alikes {
            filter.bend(self.filter.as_ref(), config).min(config.max_bend_evidence)
        } else {
            0.0
        };
        let surprise = |(index, mount): (usize, Mount)| {
            self.mount_of(index).map_or(0.0, |known| known.surprise(&mount.tilt_rad, config))
        };
        let others: f64 = filter.other_mounts().map(surprise).sum();
        slow + self.mount.surprise(&filter.mount().tilt_rad, config) + others
    }
}
