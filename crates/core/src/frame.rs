//! What a robot's sensors deliver at one moment.

use crate::{
    RgbImage, Timestamp,
    geom::{Camera, CameraFrame, Odom, PlanarPose, Rigid3, Robot},
};

/// What the feet say about the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GroundContact {
    /// Forces of the eight pressure sensors (left foot, then right), newtons.
    Pressure([f64; 8]),
    /// A yes or no from the robot itself.
    Contact(bool),
}

/// Everything a localizer may know at one moment.
#[derive(Debug, Clone)]
pub struct Frame {
    /// When the image was taken.
    pub at: Timestamp,
    /// The camera image.
    pub image: RgbImage,
    /// Which of the robot's cameras took it; 0 if it has one. Each camera keeps its index for the whole run.
    pub camera_index: usize,
    /// Calibration of the camera; its size is the image's size.
    pub camera: Camera,
    /// Pose of the camera relative to the robot's footprint, from kinematics.
    pub robot_from_camera: Rigid3<Robot, CameraFrame>,
    /// Accumulated odometry, `odom_from_robot`; `None` if the robot has none at this moment, which one that is not finite counts as.
    pub odometry: Option<PlanarPose>,
    /// Foot sensors; `None` if the robot has none.
    pub ground_contact: Option<GroundContact>,
}

impl Frame {
    /// An image of a robot that has no other sensors, or whose other sensors are added afterwards.
    pub fn new(
        at: Timestamp,
        image: RgbImage,
        camera: Camera,
        robot_from_camera: Rigid3<Robot, CameraFrame>,
    ) -> Self {
        Self { at, image, camera_index: 0, camera, robot_from_camera, odometry: None, ground_contact: None }
    }

    /// The same, taken by another camera than the first one. Frames of several cameras follow each other in the order of their stamps, which may
    /// be the same.
    #[must_use]
    pub fn of_camera(self, camera_index: usize) -> Self {
        Self { camera_index, ..self }
    }

    /// Pose of the camera by odometry and kinematics; `None` without odometry.
    pub fn odom_from_camera(&self) -> Option<Rigid3<Odom, CameraFrame>> {
        Some(self.odometry?.to_odom_from_robot() * self.robot_from_camera)
    }

    /// Whether the robot may stand on the ground, as far as its feet tell.
    pub fn may_stand(&self) -> bool {
        /// Least force of a foot on the ground, newtons.
        const LEAST_FORCE: f64 = 1.0;
        match &self.ground_contact {
            Some(GroundContact::Pressure(forces)) => forces.iter().any(|force| *force >= LEAST_FORCE),
            Some(GroundContact::Contact(is_on_ground)) => *is_on_ground,
            None => true,
        }
    }
}

/// Where the robot really was. Goes to evaluation and pictures only, never to a localizer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Pose of the robot in the map.
    pub world_from_robot: PlanarPose,
    /// Height of the footprint above the ground, meters; above 0 while somebody carries the robot.
    pub height_m: f64,
}

/// One frame with the truth, where the source knows it.
#[derive(Debug, Clone)]
pub struct SourceFrame {
    /// What the robot senses.
    pub frame: Frame,
    /// Where it really is.
    pub truth: Option<Truth>,
}
