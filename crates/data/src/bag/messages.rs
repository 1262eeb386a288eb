//! The ROS 2 messages that are read and written, in the order of their fields on the wire (CDR).

use byteorder::{BigEndian, LittleEndian};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use visloc_base::Timestamp;

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct CompressedImage {
    pub header: Header,
    pub format: String,
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Image {
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
pub(super) struct RegionOfInterest {
    pub x_offset: u32,
    pub y_offset: u32,
    pub height: u32,
    pub width: u32,
    pub do_rectify: bool,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct CameraInfo {
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
pub(super) struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

/// `geometry_msgs/Pose` and `geometry_msgs/Transform`, which look the same on the wire.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Pose {
    pub position: Vector3,
    pub orientation: Quaternion,
}

/// Row-major 6x6 covariance; nested because serde knows arrays up to 32.
pub(super) type Covariance = [[f64; 6]; 6];

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PoseWithCovariance {
    pub pose: Pose,
    pub covariance: Covariance,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TwistWithCovariance {
    pub linear: Vector3,
    pub angular: Vector3,
    pub covariance: Covariance,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Odometry {
    pub header: Header,
    pub child_frame_id: String,
    pub pose: PoseWithCovariance,
    pub twist: TwistWithCovariance,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Pose,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TfMessage {
    pub transforms: Vec<TransformStamped>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Bool {
    pub data: bool,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MultiArrayDimension {
    pub label: String,
    pub size: u32,
    pub stride: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MultiArrayLayout {
    pub dim: Vec<MultiArrayDimension>,
    pub data_offset: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Float64MultiArray {
    pub layout: MultiArrayLayout,
    pub data: Vec<f64>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PoseStamped {
    pub header: Header,
    pub pose: Pose,
}

impl Header {
    pub(super) fn new(at: Timestamp, frame_id: &str) -> Self {
        let secs = at.nanos().div_euclid(1_000_000_000);
        let nanos = at.nanos().rem_euclid(1_000_000_000);
        // A stamp outside the range of ROS (1902 to 2038) is moved to its border.
        let sec = i32::try_from(secs).unwrap_or(if secs < 0 { i32::MIN } else { i32::MAX });
        let nanosec = u32::try_from(nanos).unwrap_or(0);
        Self { stamp: Time { sec, nanosec }, frame_id: frame_id.to_string() }
    }

    pub(super) fn at(&self) -> Timestamp {
        Timestamp::from_ros(self.stamp.sec, self.stamp.nanosec)
    }
}

/// Four bytes before every message: plain CDR, little endian.
const LITTLE_ENDIAN_CDR: [u8; 4] = [0, 1, 0, 0];

/// Message from its bytes, or what is wrong with them.
pub(super) fn from_cdr<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
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
pub(super) fn to_cdr<T: Serialize>(message: &T) -> Result<Vec<u8>, String> {
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
