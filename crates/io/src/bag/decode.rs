//! From the bytes of a message to what the robot sensed.

use std::sync::Arc;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use visloc_core::{
    RgbImage, Timestamp, Truth,
    geom::{Camera, PlanarPose, Rigid3, Robot, World},
};

use crate::{
    bag::{
        TopicRole,
        messages::{self, from_cdr},
    },
    image_codec,
    raw_image::{self, RawImage},
    ros_lens::distortion_of_ros,
    urdf::RobotDescription,
};

/// A picture as it was sent.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedImage {
    /// When it was taken.
    pub at: Timestamp,
    /// Frame of the camera that took it.
    pub frame_id: String,
    /// The pixels.
    pub payload: ImagePayload,
}

/// Pixels as they were sent.
#[derive(Debug, Clone, PartialEq)]
pub enum ImagePayload {
    /// A JPEG or PNG file.
    Compressed(Vec<u8>),
    /// Rows of pixels.
    Raw(RawImage),
}

/// Pose of one frame in another at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct StampedTransform {
    /// When.
    pub at: Timestamp,
    /// Name of the outer frame.
    pub parent: String,
    /// Name of the inner frame.
    pub child: String,
    /// Takes points of the inner frame to the outer one, meters.
    pub parent_from_child: Isometry3<f64>,
}

/// One message of any topic that the [`Synchronizer`](crate::bag::Synchronizer) joins.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorMessage {
    /// A picture.
    Image(EncodedImage),
    /// Calibration of the camera.
    CameraInfo(Timestamp, Camera),
    /// Accumulated odometry, `odom_from_robot`.
    Odometry(Timestamp, PlanarPose),
    /// Poses between moving frames.
    Transforms(Vec<StampedTransform>),
    /// Poses between frames that never move against each other.
    StaticTransforms(Vec<StampedTransform>),
    /// Positions of joints by name, radians or meters, as they were sent.
    JointStates(Timestamp, Vec<(String, f64)>),
    /// Which joints the robot has. The message has no stamp: it holds from then on.
    RobotDescription(Arc<RobotDescription>),
    /// Orientation of an IMU, whose frame has this name, in a frame whose z points up.
    Imu(Timestamp, String, UnitQuaternion<f64>),
    /// Whether the feet touch the ground. The message has no stamp of its own; this is when it was sent.
    FootContact(Timestamp, bool),
    /// Forces under the feet, newtons. The message has no stamp of its own; this is when it was sent.
    FootPressure(Timestamp, [f64; 8]),
    /// Where the robot really is.
    GroundTruth(Timestamp, Truth),
}

/// A message, or a part of it, that cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub struct Reject {
    /// Its stamp, if it could be read.
    pub at: Option<Timestamp>,
    /// What was expected and what was found.
    pub reason: String,
    /// Whether every further message will have the same fault, so that going on makes no sense.
    pub is_fatal: bool,
}

impl Reject {
    fn new(at: Option<Timestamp>, reason: String) -> Self {
        Self { at, reason, is_fatal: false }
    }
}

/// A message of ROS 2 with what it is for.
// A message is moved a few times between two calls; boxes would cost an allocation each.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum RosMessage {
    /// A picture as JPEG or PNG.
    CompressedImage(messages::CompressedImage),
    /// A picture as rows of pixels.
    Image(messages::Image),
    /// Calibration.
    CameraInfo(messages::CameraInfo),
    /// Odometry.
    Odometry(messages::Odometry),
    /// Poses of frames that move.
    Tf(messages::TfMessage),
    /// Poses of frames that do not move.
    TfStatic(messages::TfMessage),
    /// Positions of joints.
    JointStates(messages::JointState),
    /// Which joints the robot has.
    RobotDescription(messages::StringMessage),
    /// How the robot is tilted.
    Imu(messages::Imu),
    /// Whether the feet touch the ground.
    FootContact(messages::Bool),
    /// Forces under the feet.
    FootPressure(messages::Float64MultiArray),
    /// Where the robot really is.
    GroundTruth(messages::PoseStamped),
}

impl RosMessage {
    /// What the robot sensed, for messages of `sent_at` or received then. What cannot be used is appended to `rejects`.
    pub fn sensed(self, sent_at: Timestamp, rejects: &mut Vec<Reject>) -> Option<SensorMessage> {
        let sensed = match self {
            Self::CompressedImage(message) => {
                Ok(encoded_image(message.header, ImagePayload::Compressed(message.data)))
            }
            Self::Image(messages::Image { header, height, width, encoding, is_bigendian, step, data }) => {
                let (size_px, is_big_endian) = ((width, height), is_bigendian != 0);
                let raw = RawImage { size_px, encoding, step, is_big_endian, data };
                Ok(encoded_image(header, ImagePayload::Raw(raw)))
            }
            Self::CameraInfo(info) => {
                camera_of(&info).map(|(at, camera)| SensorMessage::CameraInfo(at, camera))
            }
            Self::Odometry(message) => odometry(&message),
            Self::Tf(message) => Ok(SensorMessage::Transforms(transforms(message, rejects))),
            Self::TfStatic(message) => Ok(SensorMessage::StaticTransforms(transforms(message, rejects))),
            Self::JointStates(message) => joint_states(message),
            Self::RobotDescription(message) => robot_description(sent_at, &message),
            Self::Imu(message) => imu(message),
            Self::FootContact(message) => Ok(SensorMessage::FootContact(sent_at, message.data)),
            Self::FootPressure(message) => pressure(sent_at, &message),
            Self::GroundTruth(message) => truth(&message),
        };
        sensed.map_err(|reject| rejects.push(reject)).ok()
    }
}

/// A message as it stands in the recording.
#[derive(Debug)]
pub(super) struct RawMessage {
    pub role: TopicRole,
    /// Only of interest where a role has several types.
    pub is_compressed_image: bool,
    pub sent_at: Timestamp,
    pub data: Vec<u8>,
}

/// Decodes a message. What cannot be used is appended to `rejects`.
pub(super) fn decode(raw: &RawMessage, rejects: &mut Vec<Reject>) -> Option<SensorMessage> {
    let message = match raw.role {
        TopicRole::Image if raw.is_compressed_image => from_cdr(&raw.data).map(RosMessage::CompressedImage),
        TopicRole::Image => from_cdr(&raw.data).map(RosMessage::Image),
        TopicRole::CameraInfo => from_cdr(&raw.data).map(RosMessage::CameraInfo),
        TopicRole::Odometry => from_cdr(&raw.data).map(RosMessage::Odometry),
        TopicRole::Tf => from_cdr(&raw.data).map(RosMessage::Tf),
        TopicRole::TfStatic => from_cdr(&raw.data).map(RosMessage::TfStatic),
        TopicRole::JointStates => from_cdr(&raw.data).map(RosMessage::JointStates),
        TopicRole::RobotDescription => from_cdr(&raw.data).map(RosMessage::RobotDescription),
        TopicRole::Imu => from_cdr(&raw.data).map(RosMessage::Imu),
        TopicRole::FootContact => from_cdr(&raw.data).map(RosMessage::FootContact),
        TopicRole::FootPressure => from_cdr(&raw.data).map(RosMessage::FootPressure),
        TopicRole::GroundTruth => from_cdr(&raw.data).map(RosMessage::GroundTruth),
    };
    match message {
        Ok(message) => message.sensed(raw.sent_at, rejects),
        Err(reason) => {
            let has_no_stamp = matches!(
                raw.role,
                TopicRole::FootContact | TopicRole::FootPressure | TopicRole::RobotDescription
            );
            rejects.push(Reject::new(has_no_stamp.then_some(raw.sent_at), reason));
            None
        }
    }
}

fn encoded_image(header: messages::Header, payload: ImagePayload) -> SensorMessage {
    SensorMessage::Image(EncodedImage { at: header.at(), frame_id: header.frame_id, payload })
}

/// The camera that a calibration describes, and when it was sent.
///
/// # Errors
/// If the lens model is not known, or no camera has these values.
pub fn camera_of(info: &messages::CameraInfo) -> Result<(Timestamp, Camera), Reject> {
    let at = info.header.at();
    let distortion = distortion_of_ros(&info.distortion_model, &info.d).map_err(|reason| Reject {
        at: Some(at),
        reason,
        is_fatal: true,
    })?;
    let k = &info.k;
    let camera = Camera::checked((info.width, info.height), (k[0], k[4]), (k[2], k[5]), distortion)
        .map_err(|error| Reject::new(Some(at), error.to_string()))?;
    Ok((at, camera))
}

fn odometry(message: &messages::Odometry) -> Result<SensorMessage, Reject> {
    let at = message.header.at();
    let pose = rigid(&message.pose.pose)
        .ok_or_else(|| Reject::new(Some(at), not_a_pose("odometry", &message.pose.pose)))?;
    Ok(SensorMessage::Odometry(at, pose.to_planar()))
}

fn truth(message: &messages::PoseStamped) -> Result<SensorMessage, Reject> {
    let at = message.header.at();
    let pose = rigid(&message.pose)
        .ok_or_else(|| Reject::new(Some(at), not_a_pose("ground truth", &message.pose)))?;
    let truth = Truth { world_from_robot: pose.to_planar(), height_m: pose.translation().z };
    Ok(SensorMessage::GroundTruth(at, truth))
}

fn joint_states(message: messages::JointState) -> Result<SensorMessage, Reject> {
    let at = message.header.at();
    let (names, positions) = (message.name, message.position);
    // Who sends only speeds sends no positions.
    if !positions.is_empty() && positions.len() != names.len() {
        let reason =
            format!("expected {} positions, one for each joint, found {}", names.len(), positions.len());
        return Err(Reject::new(Some(at), reason));
    }
    Ok(SensorMessage::JointStates(at, names.into_iter().zip(positions).collect()))
}

fn imu(message: messages::Imu) -> Result<SensorMessage, Reject> {
    let at = message.header.at();
    let messages::Quaternion { x, y, z, w } = message.orientation;
    let quaternion = Quaternion::new(w, x, y, z);
    let is_one = (quaternion.norm() - 1.0).abs() < 0.1;
    if message.orientation_covariance[0] < 0.0 || !is_one {
        let reason = format!(
            "expected an IMU with an orientation, found ({x}, {y}, {z}, {w}) with covariance {}: a filter as imu_filter_madgwick makes one",
            message.orientation_covariance[0]
        );
        return Err(Reject { at: Some(at), reason, is_fatal: true });
    }
    let imu_frame = frame_name(&message.header.frame_id).to_owned();
    Ok(SensorMessage::Imu(at, imu_frame, UnitQuaternion::new_normalize(quaternion)))
}

fn robot_description(sent_at: Timestamp, message: &messages::StringMessage) -> Result<SensorMessage, Reject> {
    let robot =
        RobotDescription::parse(&message.data).map_err(|reason| Reject::new(Some(sent_at), reason))?;
    Ok(SensorMessage::RobotDescription(Arc::new(robot)))
}

fn pressure(sent_at: Timestamp, message: &messages::Float64MultiArray) -> Result<SensorMessage, Reject> {
    let found = message.data.as_slice();
    match <[f64; 8]>::try_from(found) {
        Ok(forces) if forces.iter().all(|force| force.is_finite()) => {
            Ok(SensorMessage::FootPressure(sent_at, forces))
        }
        _ => {
            let shown = &found[..found.len().min(10)];
            let reason = format!("expected 8 finite forces, found {} values: {shown:?}", found.len());
            Err(Reject::new(Some(sent_at), reason))
        }
    }
}

fn transforms(message: messages::TfMessage, rejects: &mut Vec<Reject>) -> Vec<StampedTransform> {
    let mut transforms = Vec::with_capacity(message.transforms.len());
    for transform in message.transforms {
        let at = transform.header.at();
        match isometry(&transform.transform) {
            Some(parent_from_child) => transforms.push(StampedTransform {
                at,
                parent: frame_name(&transform.header.frame_id).to_string(),
                child: frame_name(&transform.child_frame_id).to_string(),
                parent_from_child,
            }),
            None => {
                let what = format!("transform {} -> {}", transform.header.frame_id, transform.child_frame_id);
                rejects.push(Reject::new(Some(at), not_a_pose(&what, &transform.transform)));
            }
        }
    }
    transforms
}

/// Name of a frame without the slash that old recordings have in front.
pub(super) fn frame_name(name: &str) -> &str {
    name.strip_prefix('/').unwrap_or(name)
}

fn rigid(pose: &messages::Pose) -> Option<Rigid3<World, Robot>> {
    let (q, p) = (&pose.orientation, &pose.position);
    Rigid3::from_quaternion([q.x, q.y, q.z, q.w], [p.x, p.y, p.z])
}

fn isometry(pose: &messages::Pose) -> Option<Isometry3<f64>> {
    let rigid = rigid(pose)?;
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(*rigid.rotation());
    Some(Isometry3::from_parts(Translation3::from(*rigid.translation()), rotation.into()))
}

fn not_a_pose(what: &str, pose: &messages::Pose) -> String {
    let (p, q) = (&pose.position, &pose.orientation);
    format!(
        "{what}: expected finite numbers and a quaternion of length 1, found position ({}, {}, {}), orientation ({}, \
         {}, {}, {})",
        p.x, p.y, p.z, q.x, q.y, q.z, q.w
    )
}

impl EncodedImage {
    /// The picture.
    ///
    /// # Errors
    /// What was expected and what was found.
    pub fn decode(&self) -> Result<RgbImage, String> {
        match &self.payload {
            ImagePayload::Compressed(bytes) => image_codec::decode(bytes).map_err(|error| error.to_string()),
            ImagePayload::Raw(image) => raw_image::decode(image),
        }
    }
}
