//! What an algorithm was given, so that a recording can be recomputed.
//!
//! The image stands on the recording's ordinary ROS topic, as PNG: every pixel exact. All numbers stand here once more as they
//! were: those of ROS messages are quaternions and lose the last bit, and an algorithm that draws random numbers may turn that bit
//! into another estimate.

use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use visloc_core::{
    Frame, GrayImage, GroundContact, RgbImage, Timestamp, Truth,
    geom::{Camera, CameraFrame, Distortion, PlanarPose, Rigid3, World},
};

use crate::{Message, MessageBuilder, MessageError, MessageKind, message::lay_over};

/// Key of the array of numbers.
const NUMBERS: &str = "numbers";
/// Bytes of a number.
const NUM_BYTES: usize = 8;

/// What an algorithm is given at a moment.
#[derive(Debug, Clone, Copy)]
pub enum Input<'a> {
    /// All that a robot senses.
    Robot {
        /// What a localizer may know.
        frame: &'a Frame,
        /// Where the robot was, if that is known.
        truth: Option<&'a Truth>,
    },
    /// The image of one camera.
    Camera {
        /// When it was taken.
        at: Timestamp,
        /// The image.
        image: &'a GrayImage,
        /// Its camera.
        camera: &'a Camera,
        /// Where it was, if that is known.
        world_from_camera: Option<&'a Rigid3<World, CameraFrame>>,
    },
}

impl Input<'_> {
    /// Width and height of the image.
    pub(super) fn size_px(&self) -> (usize, usize) {
        match self {
            Self::Robot { frame, .. } => (frame.image.width() as usize, frame.image.height() as usize),
            Self::Camera { image, .. } => (image.width(), image.height()),
        }
    }

    /// When the image was taken.
    pub fn at(&self) -> Timestamp {
        match self {
            Self::Robot { frame, .. } => frame.at,
            Self::Camera { at, .. } => *at,
        }
    }
}

/// The lens as TOML, which keeps every bit.
#[derive(Serialize, Deserialize)]
struct Lens {
    lens: Distortion,
}

/// The exact numbers of an input as a message; without the image.
pub(super) fn input_message(input: &Input<'_>) -> Result<Vec<u8>, MessageError> {
    match input {
        Input::Robot { frame, truth } => robot_message(frame, *truth),
        Input::Camera { at, camera, world_from_camera, .. } => {
            camera_message(*at, camera, *world_from_camera)
        }
    }
}

fn camera_message(
    at: Timestamp,
    camera: &Camera,
    world_from_camera: Option<&Rigid3<World, CameraFrame>>,
) -> Result<Vec<u8>, MessageError> {
    let mut header = camera_fields(at, camera);
    lay_over(&mut header, &json!({ "has_truth": world_from_camera.is_some() }));
    let poses = world_from_camera.into_iter().flat_map(rigid);
    message(&header, camera_numbers(camera).into_iter().chain(poses))
}

/// What a message says of a camera besides its numbers.
fn camera_fields(at: Timestamp, camera: &Camera) -> Value {
    let lens = toml::to_string(&Lens { lens: camera.distortion() }).unwrap_or_default();
    json!({ "at_nanos": at.nanos(), "size_px": camera.size_px(), "lens": lens })
}

fn camera_numbers(camera: &Camera) -> [f64; 4] {
    let (fx, fy) = camera.focal_px();
    let (cx, cy) = camera.center_px();
    [fx, fy, cx, cy]
}

/// Rotation, column by column, and translation.
fn rigid<A, B>(pose: &Rigid3<A, B>) -> Vec<f64> {
    pose.rotation().iter().chain(pose.translation().iter()).copied().collect()
}

fn message(header: &Value, numbers: impl Iterator<Item = f64>) -> Result<Vec<u8>, MessageError> {
    let mut message = MessageBuilder::new(MessageKind::Input, header)?;
    let bytes: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
    message.bytes(NUMBERS, &bytes);
    Ok(message.finish())
}

fn robot_message(frame: &Frame, truth: Option<&Truth>) -> Result<Vec<u8>, MessageError> {
    let camera = &frame.camera;
    let (kind, forces) = match frame.ground_contact {
        None => ("none", Vec::new()),
        Some(GroundContact::Contact(false)) => ("lifted", Vec::new()),
        Some(GroundContact::Contact(true)) => ("standing", Vec::new()),
        Some(GroundContact::Pressure(forces)) => ("pressure", forces.to_vec()),
    };
    let mut header = camera_fields(frame.at, camera);
    let more =
        json!({ "has_odometry": frame.odometry.is_some(), "feet": kind, "has_truth": truth.is_some() });
    lay_over(&mut header, &more);
    if frame.camera_index > 0 {
        lay_over(&mut header, &json!({ "camera": frame.camera_index }));
    }
    let mut numbers = camera_numbers(camera).to_vec();
    numbers.extend(rigid(&frame.robot_from_camera));
    let planar = |pose: &PlanarPose| [pose.x_m, pose.y_m, pose.yaw_rad];
    numbers.extend(frame.odometry.iter().flat_map(planar));
    numbers.extend(forces);
    numbers.extend(truth.iter().flat_map(|truth| planar(&truth.world_from_robot)));
    numbers.extend(truth.iter().map(|truth| truth.height_m));
    message(&header, numbers.into_iter())
}

/// Numbers one after the other; `None` where they end.
struct Numbers<'a>(std::slice::Chunks<'a, u8>);

impl Numbers<'_> {
    fn next(&mut self) -> Option<f64> {
        Some(f64::from_le_bytes(self.0.next()?.try_into().ok()?))
    }

    fn take<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut out = [0.0; N];
        for number in &mut out {
            *number = self.next()?;
        }
        Some(out)
    }

    /// A pose; `None` as well if it is not finite.
    fn rigid<A, B>(&mut self) -> Option<Rigid3<A, B>> {
        let rotation = Matrix3::from_column_slice(&self.take::<9>()?);
        let translation = Vector3::from(self.take::<3>()?);
        let is_finite = rotation.iter().chain(translation.iter()).all(|number| number.is_finite());
        is_finite.then(|| Rigid3::new(Rotation3::from_matrix_unchecked(rotation), translation))
    }

    fn planar(&mut self) -> Option<PlanarPose> {
        let [x_m, y_m, yaw_rad] = self.take()?;
        Some(PlanarPose { x_m, y_m, yaw_rad })
    }
}

/// The camera of a message, whose numbers come first.
fn read_camera(header: &Map<String, Value>, numbers: &mut Numbers<'_>) -> Option<Camera> {
    let side = |i: usize| u32::try_from(header.get("size_px")?.get(i)?.as_u64()?).ok();
    let [fx, fy, cx, cy] = numbers.take()?;
    let Lens { lens } = toml::from_str(header.get("lens")?.as_str()?).ok()?;
    Camera::checked((side(0)?, side(1)?), (fx, fy), (cx, cy), lens).ok()
}

fn read_at(header: &Map<String, Value>) -> Option<Timestamp> {
    Some(Timestamp::from_nanos(header.get("at_nanos")?.as_i64()?))
}

/// What a camera without a map was given, but its image.
#[derive(Debug)]
pub(crate) struct CameraInput {
    pub at: Timestamp,
    pub camera: Camera,
    /// Where it was, if that is known.
    pub world_from_camera: Option<Rigid3<World, CameraFrame>>,
}

/// The input of a camera; `None` if something is missing or no number.
pub(super) fn read_camera_input(message: &Message) -> Option<CameraInput> {
    let header = &message.header;
    let mut numbers = Numbers(message.bytes(NUMBERS)?.chunks(NUM_BYTES));
    let camera = read_camera(header, &mut numbers)?;
    let has_truth = header.get("has_truth")?.as_bool()?;
    let world_from_camera = if has_truth { Some(numbers.rigid()?) } else { None };
    Some(CameraInput { at: read_at(header)?, camera, world_from_camera })
}

/// The frame of a message and its image; `None` if something is missing or no number.
pub(super) fn read_input(message: &Message, image: RgbImage) -> Option<(Frame, Option<Truth>)> {
    let header = &message.header;
    let flag = |key: &str| header.get(key)?.as_bool();
    let word = |key: &str| header.get(key)?.as_str();
    let mut numbers = Numbers(message.bytes(NUMBERS)?.chunks(NUM_BYTES));
    let camera = read_camera(header, &mut numbers)?;
    let robot_from_camera = numbers.rigid()?;
    let is_whole = camera.size_px() == (image.width(), image.height());
    let odometry = if flag("has_odometry")? { Some(numbers.planar()?) } else { None };
    let ground_contact = match word("feet")? {
        "none" => None,
        "lifted" => Some(GroundContact::Contact(false)),
        "standing" => Some(GroundContact::Contact(true)),
        _ => Some(GroundContact::Pressure(numbers.take()?)),
    };
    let truth = if flag("has_truth")? {
        Some(Truth { world_from_robot: numbers.planar()?, height_m: numbers.next()? })
    } else {
        None
    };
    let at = read_at(header)?;
    // Recordings of one camera say nothing about which.
    let camera_index =
        header.get("camera").and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok());
    let camera_index = camera_index.unwrap_or(0);
    let frame = Frame { at, image, camera_index, camera, robot_from_camera, odometry, ground_contact };
    is_whole.then_some((frame, truth))
}
