//! Where the images of one camera come from.

use crate::{
    GrayImage, SkippedInput, SourceError, SourceFrame, Timestamp,
    eval::EvaluationOptions,
    geom::{Camera, CameraFrame, Odom, Rigid3, World},
};

/// One gray image with its time, and what a robot knows of its camera.
#[derive(Debug, Clone)]
pub struct GrayFrame {
    /// When it was taken.
    pub at: Timestamp,
    /// The image; its size is the camera's.
    pub image: GrayImage,
    /// Pose of the camera by the robot's odometry and kinematics, meters; `None` for a camera that is not on a robot.
    pub odom_from_camera: Option<Rigid3<Odom, CameraFrame>>,
    /// Where the camera really was, where the source says so with every image. Goes to evaluation and pictures only.
    pub truth: Option<Rigid3<World, CameraFrame>>,
}

impl GrayFrame {
    /// An image of a camera of which nothing else is known.
    #[must_use]
    pub fn new(at: Timestamp, image: GrayImage) -> Self {
        Self { at, image, odom_from_camera: None, truth: None }
    }

    /// What the camera of a robot sees. With its feet in the air the robot's odometry says nothing; while it is carried nobody knows
    /// the truth.
    #[must_use]
    pub fn of_robot(source: SourceFrame) -> Self {
        let SourceFrame { frame, truth } = source;
        let truth = truth.filter(|truth| truth.height_m <= EvaluationOptions::default().max_ground_height_m);
        Self {
            at: frame.at,
            image: GrayImage::from_rgb(&frame.image),
            odom_from_camera: frame.odom_from_camera().filter(|_| frame.may_stand()),
            truth: truth.map(|truth| truth.world_from_robot.to_rigid3() * frame.robot_from_camera),
        }
    }
}

/// Everything that delivers the images of one calibrated camera: a dataset, a folder, a live camera.
pub trait ImageSource {
    /// The camera of all images.
    fn camera(&self) -> &Camera;

    /// The next image in order of time, `None` at the end. After an error there are no more images.
    fn next_image(&mut self) -> Option<Result<GrayFrame, SourceError>>;

    /// How many images there will be, if that is known; those that cannot be read count.
    fn num_images(&self) -> Option<usize> {
        None
    }

    /// What was left out so far.
    fn skipped(&self) -> &[SkippedInput] {
        &[]
    }

    /// How many images of a live source came while nobody was ready for them.
    fn num_dropped(&self) -> usize {
        0
    }
}
