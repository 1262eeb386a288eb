//! Trajectories of a camera in space.

use visloc_geom::{CameraFrame, Rigid3, World};

use crate::Timestamp;

/// A camera's pose at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// When.
    pub at: Timestamp,
    /// Where the camera is.
    pub world_from_camera: Rigid3<World, CameraFrame>,
}

/// Camera poses in order of time. Stamps strictly increase.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CameraTrajectory {
    poses: Vec<CameraPose>,
}

impl CameraTrajectory {
    /// An empty trajectory.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends a pose. A pose that is not later than the last one is refused and handed back.
    ///
    /// # Errors
    /// The refused pose.
    pub fn push(&mut self, pose: CameraPose) -> Result<(), CameraPose> {
        if self.poses.last().is_some_and(|last| last.at >= pose.at) {
            return Err(pose);
        }
        self.poses.push(pose);
        Ok(())
    }

    /// All poses in order of time.
    #[must_use]
    pub fn poses(&self) -> &[CameraPose] {
        &self.poses
    }

    /// The pose nearest in time to `at`, if one lies within `tolerance_secs`; the earlier one of two that are as near.
    #[must_use]
    pub fn nearest(&self, at: Timestamp, tolerance_secs: f64) -> Option<&CameraPose> {
        let after = self.poses.partition_point(|pose| pose.at < at);
        [after.checked_sub(1), Some(after)]
            .into_iter()
            .flatten()
            .filter_map(|i| self.poses.get(i))
            .min_by(|a, b| a.at.secs_since(at).abs().total_cmp(&b.at.secs_since(at).abs()))
            .filter(|pose| pose.at.secs_since(at).abs() <= tolerance_secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_order_and_finds_the_nearest() {
        let pose =
            |secs| CameraPose { at: Timestamp::from_secs(secs), world_from_camera: Rigid3::identity() };
        let mut trajectory = CameraTrajectory::new();
        trajectory.push(pose(1.0)).unwrap();
        assert!(trajectory.push(pose(1.0)).is_err());
        trajectory.push(pose(2.0)).unwrap();
        assert_eq!(trajectory.nearest(Timestamp::from_secs(1.6), 0.45), Some(&pose(2.0)));
        assert_eq!(trajectory.nearest(Timestamp::from_secs(1.6), 0.3), None);
    }
}
