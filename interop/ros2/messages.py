"""The messages of ROS 2 that the scripts here exchange, as Cyclone DDS sees them.

ROS 2 puts `rt` before the name of a topic and mangles the name of a type; the fields are those of the message definitions.
"""

from dataclasses import dataclass
from types import new_class

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, int64, sequence, uint8, uint32, uint64


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class CompressedImage(IdlStruct, typename="sensor_msgs::msg::dds_::CompressedImage_"):
    header: Header
    format: str
    data: sequence[uint8]


@dataclass
class Image(IdlStruct, typename="sensor_msgs::msg::dds_::Image_"):
    header: Header
    height: uint32
    width: uint32
    encoding: str
    is_bigendian: uint8
    step: uint32
    data: sequence[uint8]


@dataclass
class RegionOfInterest(IdlStruct, typename="sensor_msgs::msg::dds_::RegionOfInterest_"):
    x_offset: uint32
    y_offset: uint32
    height: uint32
    width: uint32
    do_rectify: bool


@dataclass
class CameraInfo(IdlStruct, typename="sensor_msgs::msg::dds_::CameraInfo_"):
    header: Header
    height: uint32
    width: uint32
    distortion_model: str
    d: sequence[float64]
    k: array[float64, 9]
    r: array[float64, 9]
    p: array[float64, 12]
    binning_x: uint32
    binning_y: uint32
    roi: RegionOfInterest


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Vector3
    orientation: Quaternion


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: Pose
    covariance: array[float64, 36]


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3
    angular: Vector3


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist
    covariance: array[float64, 36]


@dataclass
class JointTrajectoryPoint(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectoryPoint_"):
    positions: sequence[float64]
    velocities: sequence[float64]
    accelerations: sequence[float64]
    effort: sequence[float64]
    time_from_start: Time


@dataclass
class JointTrajectory(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectory_"):
    header: Header
    joint_names: sequence[str]
    points: sequence[JointTrajectoryPoint]


@dataclass
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Pose  # translation and rotation, which look the same on the wire


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: sequence[TransformStamped]


@dataclass
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


@dataclass
class Float64(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):
    data: float64


@dataclass
class Empty(IdlStruct, typename="std_msgs::msg::dds_::Empty_"):
    structure_needs_at_least_one_member: uint8


@dataclass
class PoseStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PoseStamped_"):
    header: Header
    pose: Pose


@dataclass
class PoseWithCovarianceStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovarianceStamped_"):
    header: Header
    pose: PoseWithCovariance


@dataclass
class PoseArray(IdlStruct, typename="geometry_msgs::msg::dds_::PoseArray_"):
    header: Header
    poses: sequence[Pose]


@dataclass
class Path(IdlStruct, typename="nav_msgs::msg::dds_::Path_"):
    header: Header
    poses: sequence[PoseStamped]


@dataclass
class NodeState(IdlStruct, typename="lifecycle_msgs::msg::dds_::State_"):
    id: uint8
    label: str


@dataclass
class MapMetaData(IdlStruct, typename="nav_msgs::msg::dds_::MapMetaData_"):
    map_load_time: Time
    resolution: float32
    width: uint32
    height: uint32
    origin: Pose


@dataclass
class OccupancyGrid(IdlStruct, typename="nav_msgs::msg::dds_::OccupancyGrid_"):
    header: Header
    info: MapMetaData
    data: sequence[int8]


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class PointField(IdlStruct, typename="sensor_msgs::msg::dds_::PointField_"):
    name: str
    offset: uint32
    datatype: uint8
    count: uint32


@dataclass
class PointCloud2(IdlStruct, typename="sensor_msgs::msg::dds_::PointCloud2_"):
    header: Header
    height: uint32
    width: uint32
    fields: sequence[PointField]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool


def service(package, name, is_cyclone, fields):
    """Request and answer of a service as Fast DDS has them, or as Cyclone DDS below ROS has, which puts client and number before the content."""
    number = {"client": uint64, "number": int64} if is_cyclone else {}

    def message(kind, content):
        content = {**number, **content}
        typename = f"{package}::srv::dds_::{name}_{kind}_"
        body = {"__annotations__": content, "__module__": __name__}
        return dataclass(new_class(name + kind, (IdlStruct,), {"typename": typename}, lambda of: of.update(body)))

    return message("Request", fields), message("Response", {"success": bool, "message": str})


def _header(h):
    return Header(Time(h.stamp.sec, h.stamp.nanosec), h.frame_id)


def _vector(v):
    return Vector3(v.x, v.y, v.z)


def _quaternion(q):
    return Quaternion(q.x, q.y, q.z, q.w)


def _pose(p):
    return Pose(_vector(p.position), _quaternion(p.orientation))


def _compressed_image(m):
    return CompressedImage(_header(m.header), m.format, bytes(m.data))


def _camera_info(m):
    roi = RegionOfInterest(m.roi.x_offset, m.roi.y_offset, m.roi.height, m.roi.width, m.roi.do_rectify)
    return CameraInfo(
        _header(m.header), m.height, m.width, m.distortion_model, list(m.d), list(m.k), list(m.r), list(m.p),
        m.binning_x, m.binning_y, roi,
    )


def _odometry(m):
    twist = Twist(_vector(m.twist.twist.linear), _vector(m.twist.twist.angular))
    return Odometry(
        _header(m.header), m.child_frame_id,
        PoseWithCovariance(_pose(m.pose.pose), list(m.pose.covariance)),
        TwistWithCovariance(twist, list(m.twist.covariance)),
    )


def _tf(m):
    def one(t):
        pose = Pose(_vector(t.transform.translation), _quaternion(t.transform.rotation))
        return TransformStamped(_header(t.header), t.child_frame_id, pose)

    return TFMessage([one(t) for t in m.transforms])


# Type in a bag -> class here, and how a decoded message becomes one.
FROM_BAG = {
    "sensor_msgs/msg/CompressedImage": (CompressedImage, _compressed_image),
    "sensor_msgs/msg/CameraInfo": (CameraInfo, _camera_info),
    "nav_msgs/msg/Odometry": (Odometry, _odometry),
    "tf2_msgs/msg/TFMessage": (TFMessage, _tf),
    "std_msgs/msg/Bool": (Bool, lambda m: Bool(m.data)),
    "geometry_msgs/msg/PoseStamped": (PoseStamped, lambda m: PoseStamped(_header(m.header), _pose(m.pose))),
}
