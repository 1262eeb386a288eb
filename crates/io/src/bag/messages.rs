//! The ROS 2 messages that are read and written, in the order of their fields on the wire (CDR). Names and fields are those of
//! the message definitions of ROS 2 ([`definition`](super::definition) has the text), which say what they mean.
#![allow(missing_docs)]

use byteorder::{BigEndian, LittleEndian};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use visloc_core::{
    Timestamp,
    geom::{PlanarPose, Rigid3},
};

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CompressedImage {
    pub header: Header,
    pub format: String,
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Image {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub encoding: String,
    pub is_bigendian: u8,
    pub step: u32,
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct RegionOfInterest {
    pub x_offset: u32,
    pub y_offset: u32,
    pub height: u32,
    pub width: u32,
    pub do_rectify: bool,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraInfo {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub distortion_model: String,
    pub d: Vec<f64>,
    pub k: [f64; 9],
    pub r: [f64; 9],
    pub p: [f64; 12],
    pub binning_x: u32,
    pub binning_y: u32,
    pub roi: RegionOfInterest,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

/// `geometry_msgs/Pose` and `geometry_msgs/Transform`, which look the same on the wire.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    pub position: Vector3,
    pub orientation: Quaternion,
}

/// Row-major 6x6 covariance; nested because serde knows arrays up to 32.
pub type Covariance = [[f64; 6]; 6];

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    pub pose: Pose,
    pub covariance: Covariance,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    pub linear: Vector3,
    pub angular: Vector3,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct JointTrajectory {
    pub header: Header,
    pub joint_names: Vec<String>,
    pub points: Vec<JointTrajectoryPoint>,
}

/// What is empty is left to the controller; the time is from the message's stamp on, at once if that is 0.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct JointTrajectoryPoint {
    pub positions: Vec<f64>,
    pub velocities: Vec<f64>,
    pub accelerations: Vec<f64>,
    pub effort: Vec<f64>,
    pub time_from_start: Time,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    pub linear: Vector3,
    pub angular: Vector3,
    pub covariance: Covariance,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    pub header: Header,
    pub child_frame_id: String,
    pub pose: PoseWithCovariance,
    pub twist: TwistWithCovariance,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Pose,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TfMessage {
    pub transforms: Vec<TransformStamped>,
}

/// Lists that are not known are empty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    pub header: Header,
    pub name: Vec<String>,
    /// Radians or meters.
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub effort: Vec<f64>,
}

/// `sensor_msgs/Imu`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Imu {
    pub header: Header,
    pub orientation: Quaternion,
    /// The first number is -1 if there is no orientation.
    pub orientation_covariance: [f64; 9],
    /// Radians per second.
    pub angular_velocity: Vector3,
    pub angular_velocity_covariance: [f64; 9],
    /// Meters per second squared.
    pub linear_acceleration: Vector3,
    pub linear_acceleration_covariance: [f64; 9],
}

/// `std_msgs/String`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StringMessage {
    pub data: String,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Bool {
    pub data: bool,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiArrayDimension {
    pub label: String,
    pub size: u32,
    pub stride: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiArrayLayout {
    pub dim: Vec<MultiArrayDimension>,
    pub data_offset: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Float64MultiArray {
    pub layout: MultiArrayLayout,
    pub data: Vec<f64>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    pub header: Header,
    pub pose: Pose,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovarianceStamped {
    pub header: Header,
    pub pose: PoseWithCovariance,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Path {
    pub header: Header,
    pub poses: Vec<PoseStamped>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseArray {
    pub header: Header,
    pub poses: Vec<Pose>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Float64 {
    pub data: f64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MapMetaData {
    pub map_load_time: Time,
    pub resolution: f32,
    pub width: u32,
    pub height: u32,
    /// Of the lower left corner.
    pub origin: Pose,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct OccupancyGrid {
    pub header: Header,
    pub info: MapMetaData,
    /// Rows from the bottom: 0 free, 100 occupied, -1 unknown.
    pub data: Vec<i8>,
}

/// State of a managed node, `lifecycle_msgs/msg/State`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodeState {
    pub id: u8,
    pub label: String,
}

/// ROS gives a message without fields this one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Empty {
    pub structure_needs_at_least_one_member: u8,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct KeyValue {
    pub key: String,
    pub value: String,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// 0 all is well, 1 a warning, 2 an error, 3 stale.
    pub level: u8,
    pub name: String,
    pub message: String,
    pub hardware_id: String,
    pub values: Vec<KeyValue>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    pub header: Header,
    pub status: Vec<DiagnosticStatus>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PointField {
    pub name: String,
    pub offset: u32,
    /// 7 is a float of 32 bits.
    pub datatype: u8,
    pub count: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PointCloud2 {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub fields: Vec<PointField>,
    pub is_bigendian: bool,
    pub point_step: u32,
    pub row_step: u32,
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
    pub is_dense: bool,
}

impl Pose {
    /// A pose on the ground, or so high above it, in meters.
    pub fn planar(pose: &PlanarPose, height_m: f64) -> Self {
        let (z, w) = (0.5 * pose.yaw_rad).sin_cos();
        Self {
            position: Vector3 { x: pose.x_m, y: pose.y_m, z: height_m },
            orientation: Quaternion { x: 0.0, y: 0.0, z, w },
        }
    }

    /// Any pose.
    pub fn rigid<Dst, Src>(pose: &Rigid3<Dst, Src>) -> Self {
        let (t, [x, y, z, w]) = (pose.translation(), pose.quaternion_xyzw());
        Self { position: Vector3 { x: t.x, y: t.y, z: t.z }, orientation: Quaternion { x, y, z, w } }
    }
}

impl Header {
    /// A header with the stamp nearest to a time that ROS can say.
    pub fn new(at: Timestamp, frame_id: &str) -> Self {
        let secs = at.nanos().div_euclid(1_000_000_000);
        let nanos = at.nanos().rem_euclid(1_000_000_000);
        // A stamp outside the range of ROS (1902 to 2038) is moved to its border.
        let sec = i32::try_from(secs).unwrap_or(if secs < 0 { i32::MIN } else { i32::MAX });
        let nanosec = u32::try_from(nanos).unwrap_or(0);
        Self { stamp: Time { sec, nanosec }, frame_id: frame_id.to_string() }
    }

    /// The stamp.
    pub fn at(&self) -> Timestamp {
        Timestamp::from_ros(self.stamp.sec, self.stamp.nanosec)
    }
}

/// Four bytes before every message: plain CDR, little endian.
const LITTLE_ENDIAN_CDR: [u8; 4] = [0, 1, 0, 0];

/// Message from its bytes.
///
/// # Errors
/// What is wrong with them.
pub fn from_cdr<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    let Some((encapsulation, body)) = bytes.split_at_checked(4) else {
        return Err(format!("expected a CDR message, found {} bytes", bytes.len()));
    };
    let decoded = match encapsulation[..2] {
        [0, 0] => cdr_encoding::from_bytes::<T, BigEndian>(body),
        [0, 1] => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        _ => return Err(format!("expected plain CDR (00 00 or 00 01), found {encapsulation:02x?}")),
    };
    decoded.map(|(message, _)| message).map_err(|error| {
        let name = std::any::type_name::<T>().rsplit("::").next().unwrap_or_default();
        format!("expected a {name} message, found {} bytes that are none: {error}", bytes.len())
    })
}

/// Bytes of a message.
///
/// # Errors
/// If something in it has no place in CDR.
pub fn to_cdr<T: Serialize>(message: &T) -> Result<Vec<u8>, String> {
    let body = cdr_encoding::to_vec::<T, LittleEndian>(message).map_err(|error| error.to_string())?;
    Ok([&LITTLE_ENDIAN_CDR[..], &body].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_by_hand() {
        let header = Header::new(Timestamp::from_nanos(2_000_000_003), "ab");
        assert_eq!(to_cdr(&header).unwrap(), [0, 1, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0]);
        let image = CompressedImage { header, format: "jpeg".into(), data: vec![7, 8] };
        let bytes = to_cdr(&image).unwrap();
        // the lengths of strings and arrays stand at multiples of four behind the first four bytes
        let rest = [0, 5, 0, 0, 0, b'j', b'p', b'e', b'g', 0, 0, 0, 0, 2, 0, 0, 0, 7, 8];
        assert_eq!(bytes[19..], rest);
        assert_eq!(from_cdr::<CompressedImage>(&bytes).unwrap(), image);
    }

    #[test]
    fn big_endian_is_read_too() {
        let bytes = [0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 2, b'a', 0];
        let header: Header = from_cdr(&bytes).unwrap();
        assert_eq!((header.at(), header.frame_id.as_str()), (Timestamp::from_nanos(2_000_000_003), "a"));
    }

    #[test]
    fn damage_is_described() {
        let bytes = to_cdr(&PoseStamped::default()).unwrap();
        for length in 0..bytes.len() {
            let error = from_cdr::<PoseStamped>(&bytes[..length]).unwrap_err();
            assert!(error.contains("expected"), "{error}");
        }
        assert!(from_cdr::<Bool>(&[0, 9, 0, 0, 1]).unwrap_err().contains("plain CDR"));
    }
}
