//! Coordinate frames as empty types. All are right-handed.

/// The map frame. RoboCup field: origin at the center of the field, +x towards the first goal of the map file (the
/// yellow goal in the 2010 field), z up. Office: as the map file says, z up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum World {}

/// The robot's footprint: on the ground between the feet, x forward, y left, z up (ROS: `base_footprint`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Robot {}

/// The camera's optical frame: origin at the center of projection, x right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraFrame {}

/// The frame in which odometry accumulates: fixed where the robot was switched on, drifts against [`World`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Odom {}
