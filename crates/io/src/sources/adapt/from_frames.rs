//! Pictures and gray images of a source that delivers more.

use visloc_core::{
    Frame, FrameSource, GrayFrame, GrayImage, GroundContact, ImageSource, Picture, PictureSource,
    SkippedInput, SourceError, SourceFrame, Truth,
    eval::EvaluationOptions,
    geom::{Camera, CameraFrame, Rigid3, World},
};

use super::GrayStream;
use crate::sources::video::in_color;

/// The pictures of a robot's camera. The camera is that of the first frame.
pub(crate) struct FramePictures {
    frames: Box<dyn FrameSource>,
    first: Option<SourceFrame>,
    camera: Camera,
}

impl FramePictures {
    /// Reads the first frame; `None` if there is none.
    pub(crate) fn new(mut frames: Box<dyn FrameSource>) -> Option<Result<Self, SourceError>> {
        let first = match frames.next_frame()? {
            Ok(first) => first,
            Err(error) => return Some(Err(error)),
        };
        Some(Ok(Self { frames, camera: first.frame.camera, first: Some(first) }))
    }

    pub(crate) fn camera(&self) -> &Camera {
        &self.camera
    }
}

impl PictureSource for FramePictures {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        let next = self.first.take().map(Ok).or_else(|| self.frames.next_frame())?;
        Some(next.map(|SourceFrame { frame, .. }| Picture { at: frame.at, image: frame.image }))
    }

    fn num_pictures(&self) -> Option<usize> {
        self.frames.num_frames()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.frames.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.frames.num_dropped()
    }
}

/// The gray images of a robot's camera, with what its odometry says of it.
impl GrayStream for FramePictures {
    fn next_gray(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        let next = self.first.take().map(Ok).or_else(|| self.frames.next_frame())?;
        Some(next.map(|SourceFrame { frame, truth }| GrayFrame {
            at: frame.at,
            image: GrayImage::from_rgb(&frame.image),
            odom_from_camera: frame.odom_from_camera().filter(|_| stands(&frame)),
            truth: truth.and_then(|truth| world_from_camera(&truth, &frame)),
        }))
    }

    fn num_images(&self) -> Option<usize> {
        self.frames.num_frames()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.frames.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.frames.num_dropped()
    }
}

/// Least force of a foot on the ground, newtons.
const LEAST_FORCE: f64 = 1.0;

/// Whether the robot's feet may touch the ground: in the air its odometry says nothing.
fn stands(frame: &Frame) -> bool {
    match &frame.ground_contact {
        Some(GroundContact::Pressure(forces)) => forces.iter().any(|force| *force >= LEAST_FORCE),
        Some(GroundContact::Contact(is_on_ground)) => *is_on_ground,
        None => true,
    }
}

/// Where the robot's camera really was; nobody knows while the robot is carried.
fn world_from_camera(truth: &Truth, frame: &Frame) -> Option<Rigid3<World, CameraFrame>> {
    let is_on_ground = truth.height_m <= EvaluationOptions::default().max_ground_height_m;
    is_on_ground.then(|| truth.world_from_robot.to_rigid3() * frame.robot_from_camera)
}

/// Gray images as pictures.
pub(crate) struct PicturesOfImages(pub Box<dyn ImageSource>);

impl PictureSource for PicturesOfImages {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        Some(self.0.next_image()?.map(|frame| Picture { at: frame.at, image: in_color(&frame.image) }))
    }

    fn num_pictures(&self) -> Option<usize> {
        self.0.num_images()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.0.skipped()
    }

    fn num_dropped(&self) -> usize {
        self.0.num_dropped()
    }
}
