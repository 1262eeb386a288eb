//! What a robot's sensors deliver at one moment, and where such frames come from.

use thiserror::Error;

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
    /// Accumulated odometry, `odom_from_robot`; `None` if the robot has none at this moment.
    pub odometry: Option<PlanarPose>,
    /// Foot sensors; `None` if the robot has none.
    pub ground_contact: Option<GroundContact>,
}

impl Frame {
    /// An image of a robot that has no other sensors, or whose other sensors are added afterwards.
    #[must_use]
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
    #[must_use]
    pub fn odom_from_camera(&self) -> Option<Rigid3<Odom, CameraFrame>> {
        Some(self.odometry?.to_odom_from_robot() * self.robot_from_camera)
    }

    /// Whether the robot may stand on the ground, as far as its feet tell.
    #[must_use]
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

/// Input that could not be used and was left out; the run goes on without it.
#[derive(Debug, Clone, PartialEq)]
pub struct SkippedInput {
    /// Stamp of the message, if it could be read.
    pub at: Option<Timestamp>,
    /// Where it came from, for instance the topic.
    pub origin: String,
    /// What was expected and what was found.
    pub reason: String,
}

/// Why a source has to stop. The frames before it stay valid.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The input ends in the middle or is damaged.
    #[error("{origin}: {reason}")]
    Broken {
        /// File or device, with the place in it.
        origin: String,
        /// What was expected and what was found.
        reason: String,
    },
}

/// Everything that delivers frames: a simulator, a recording, a robot.
pub trait FrameSource {
    /// The next frame in order of time, `None` at the end. After an error there are no more frames.
    fn next_frame(&mut self) -> Option<Result<SourceFrame, SourceError>>;

    /// How many frames there will be, if that is known. For progress bars.
    fn num_frames(&self) -> Option<usize> {
        None
    }

    /// What was left out so far.
    fn skipped(&self) -> &[SkippedInput] {
        &[]
    }

    /// How many frames of a live source came while nobody was ready for them.
    fn num_dropped(&self) -> usize {
        0
    }

    /// When the last frame of a live source was complete, by the clock of its host: a message may have come later than its
    /// stamp says.
    fn received_at(&self) -> Option<Timestamp> {
        None
    }
}

/// A source whose frames are changed on their way, one by one.
pub struct ChangedFrames<F> {
    inner: Box<dyn FrameSource>,
    change: F,
}

impl<F: FnMut(&mut Frame)> ChangedFrames<F> {
    /// Over a source.
    #[must_use]
    pub fn new(inner: Box<dyn FrameSource>, change: F) -> Self {
        Self { inner, change }
    }
}

impl<F: FnMut(&mut Frame)> FrameSource for ChangedFrames<F> {
    fn next_frame(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        let mut next = self.inner.next_frame()?;
        if let Ok(SourceFrame { frame, .. }) = &mut next {
            (self.change)(frame);
        }
        Some(next)
    }

    fn num_frames(&self) -> Option<usize> {
        self.inner.num_frames()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.inner.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.inner.num_dropped()
    }

    fn received_at(&self) -> Option<Timestamp> {
        self.inner.received_at()
    }
}
