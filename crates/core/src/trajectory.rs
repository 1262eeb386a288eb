//! Poses over time: of a robot in the plane and of a camera in space.

use crate::{
    Timestamp,
    geom::{CameraFrame, PlanarPose, Rigid3, World},
};

/// Pose of a robot at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampedPose {
    /// When.
    pub at: Timestamp,
    /// Pose of the robot in the map.
    pub world_from_robot: PlanarPose,
    /// Height of the footprint above the ground, meters: 0 for a walking robot.
    pub height_m: f64,
}

/// Pose of a camera at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// When.
    pub at: Timestamp,
    /// Where the camera is.
    pub world_from_camera: Rigid3<World, CameraFrame>,
}

/// Something that was so at a time.
pub trait Stamped {
    /// When.
    fn at(&self) -> Timestamp;
}

impl Stamped for StampedPose {
    fn at(&self) -> Timestamp {
        self.at
    }
}

impl Stamped for CameraPose {
    fn at(&self) -> Timestamp {
        self.at
    }
}

/// Poses of a robot.
pub type PlanarTrajectory = Trajectory<StampedPose>;
/// Poses of a camera.
pub type CameraTrajectory = Trajectory<CameraPose>;

/// Poses in order of time. Stamps strictly increase.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory<P> {
    poses: Vec<P>,
}

impl<P> Default for Trajectory<P> {
    fn default() -> Self {
        Self { poses: Vec::new() }
    }
}

impl<P: Stamped> Trajectory<P> {
    /// An empty trajectory.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends a pose. A pose that is not later than the last one is refused and handed back.
    ///
    /// # Errors
    /// The refused pose.
    pub fn push(&mut self, pose: P) -> Result<(), P> {
        if self.poses.last().is_some_and(|last| last.at() >= pose.at()) {
            return Err(pose);
        }
        self.poses.push(pose);
        Ok(())
    }

    /// All poses in order of time.
    pub fn poses(&self) -> &[P] {
        &self.poses
    }

    /// The pose nearest in time to `at`, if one lies within `tolerance_secs`; the earlier one of two that are as near.
    pub fn nearest(&self, at: Timestamp, tolerance_secs: f64) -> Option<&P> {
        let distance_secs = |pose: &P| pose.at().secs_since(at).abs();
        let after = self.poses.partition_point(|pose| pose.at() < at);
        [after.checked_sub(1), Some(after)]
            .into_iter()
            .flatten()
            .filter_map(|i| self.poses.get(i))
            .min_by(|a, b| distance_secs(a).total_cmp(&distance_secs(b)))
            .filter(|pose| distance_secs(pose) <= tolerance_secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(secs: f64) -> StampedPose {
        StampedPose {
            at: Timestamp::from_secs(secs),
            world_from_robot: PlanarPose::new(secs, 0.0, 0.0),
            height_m: 0.0,
        }
    }

    #[test]
    fn order_is_kept() {
        let mut trajectory = PlanarTrajectory::new();
        trajectory.push(pose(1.0)).unwrap();
        assert_eq!(trajectory.push(pose(1.0)), Err(pose(1.0)));
        assert_eq!(trajectory.push(pose(0.5)), Err(pose(0.5)));
        trajectory.push(pose(2.0)).unwrap();
        assert_eq!(trajectory.poses().len(), 2);
    }

    #[test]
    fn nearest_in_time_within_tolerance() {
        let mut trajectory = PlanarTrajectory::new();
        for secs in [1.0, 2.0, 3.0] {
            trajectory.push(pose(secs)).unwrap();
        }
        let at = |secs| trajectory.nearest(Timestamp::from_secs(secs), 0.45).map(|p| p.world_from_robot.x_m);
        assert_eq!(at(2.4), Some(2.0));
        assert_eq!(at(2.6), Some(3.0));
        assert_eq!(at(3.4), Some(3.0));
        assert_eq!(at(3.6), None);
        assert_eq!(PlanarTrajectory::new().nearest(Timestamp::default(), 1.0), None);
    }
}
