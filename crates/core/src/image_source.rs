//! Images of one camera.

use crate::{
    GrayImage, RgbImage, Source, SourceError, SourceFrame, SourceStatus, Timestamp,
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
    pub fn new(at: Timestamp, image: GrayImage) -> Self {
        Self { at, image, odom_from_camera: None, truth: None }
    }

    /// What the camera of a robot sees. With its feet in the air the robot's odometry says nothing; while it is carried nobody knows
    /// the truth.
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

/// One color image with its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// When it was taken.
    pub at: Timestamp,
    /// The image.
    pub image: RgbImage,
    /// The file that it was in the source, JPEG or PNG, where it was one.
    pub file: Option<Vec<u8>>,
}

/// The images of one calibrated camera: a dataset, a folder, a live camera.
pub trait ImageSource: Source<GrayFrame> {
    /// The camera of all images.
    fn camera(&self) -> &Camera;
}

impl<S: ImageSource + ?Sized> ImageSource for Box<S> {
    fn camera(&self) -> &Camera {
        (**self).camera()
    }
}

/// Gray images whose camera is known.
pub struct CalibratedImages {
    camera: Camera,
    images: Box<dyn Source<GrayFrame>>,
}

crate::debug_shows!([] CalibratedImages { camera });

impl CalibratedImages {
    /// All images have the size of the camera.
    pub fn new(camera: Camera, images: Box<dyn Source<GrayFrame>>) -> Self {
        Self { camera, images }
    }
}

impl Source<GrayFrame> for CalibratedImages {
    fn next_item(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        self.images.next_item()
    }

    fn status(&self) -> SourceStatus<'_> {
        self.images.status()
    }
}

impl ImageSource for CalibratedImages {
    fn camera(&self) -> &Camera {
        &self.camera
    }
}
