//! Definitions of the messages that are written (`ros2msg`), complete with everything they contain, so that any tool
//! can decode a recording from the file alone.

/// Message types that are written and what they contain, without `msg/`, with their fields.
#[rustfmt::skip]
const TYPES: [(&str, &str); 34] = [
    ("sensor_msgs/CompressedImage", "std_msgs/Header header; string format; uint8[] data"),
    ("sensor_msgs/Image", "std_msgs/Header header; uint32 height; uint32 width; string encoding; uint8 is_bigendian; uint32 step; uint8[] data"),
    ("sensor_msgs/CameraInfo", "std_msgs/Header header; uint32 height; uint32 width; string distortion_model; float64[] d; float64[9] k; float64[9] r; float64[12] p; uint32 binning_x; uint32 binning_y; sensor_msgs/RegionOfInterest roi"),
    ("nav_msgs/Odometry", "std_msgs/Header header; string child_frame_id; geometry_msgs/PoseWithCovariance pose; geometry_msgs/TwistWithCovariance twist"),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms"),
    ("sensor_msgs/JointState", "std_msgs/Header header; string[] name; float64[] position; float64[] velocity; float64[] effort"),
    ("sensor_msgs/Imu", "std_msgs/Header header; geometry_msgs/Quaternion orientation; float64[9] orientation_covariance; geometry_msgs/Vector3 angular_velocity; float64[9] angular_velocity_covariance; geometry_msgs/Vector3 linear_acceleration; float64[9] linear_acceleration_covariance"),
    ("std_msgs/String", "string data"),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Float64MultiArray", "std_msgs/MultiArrayLayout layout; float64[] data"),
    ("geometry_msgs/PoseWithCovarianceStamped", "std_msgs/Header header; geometry_msgs/PoseWithCovariance pose"),
    ("geometry_msgs/PoseArray", "std_msgs/Header header; geometry_msgs/Pose[] poses"),
    ("nav_msgs/Path", "std_msgs/Header header; geometry_msgs/PoseStamped[] poses"),
    ("std_msgs/Float64", "float64 data"),
    ("diagnostic_msgs/DiagnosticArray", "std_msgs/Header header; diagnostic_msgs/DiagnosticStatus[] status"),
    ("sensor_msgs/PointCloud2", "std_msgs/Header header; uint32 height; uint32 width; sensor_msgs/PointField[] fields; bool is_bigendian; uint32 point_step; uint32 row_step; uint8[] data; bool is_dense"),
    ("builtin_interfaces/Time", "int32 sec; uint32 nanosec"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp; string frame_id"),
    ("geometry_msgs/Point", "float64 x; float64 y; float64 z"),
    ("geometry_msgs/Vector3", "float64 x; float64 y; float64 z"),
    ("geometry_msgs/Quaternion", "float64 x; float64 y; float64 z; float64 w"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position; geometry_msgs/Quaternion orientation"),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear; geometry_msgs/Vector3 angular"),
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation; geometry_msgs/Quaternion rotation"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose; float64[36] covariance"),
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist; float64[36] covariance"),
    ("geometry_msgs/TransformStamped", "std_msgs/Header header; string child_frame_id; geometry_msgs/Transform transform"),
    ("sensor_msgs/RegionOfInterest", "uint32 x_offset; uint32 y_offset; uint32 height; uint32 width; bool do_rectify"),
    ("std_msgs/MultiArrayDimension", "string label; uint32 size; uint32 stride"),
    ("std_msgs/MultiArrayLayout", "std_msgs/MultiArrayDimension[] dim; uint32 data_offset"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header; geometry_msgs/Pose pose"),
    ("diagnostic_msgs/KeyValue", "string key; string value"),
    ("diagnostic_msgs/DiagnosticStatus", "byte level; string name; string message; string hardware_id; diagnostic_msgs/KeyValue[] values"),
    ("sensor_msgs/PointField", "string name; uint32 offset; uint8 datatype; uint32 count"),
];

/// Definition of a message type with all it contains; `None` for a type that is never written.
pub fn definition(type_name: &str) -> Option<String> {
    let name = type_name.replacen("/msg/", "/", 1);
    let (_, fields) = TYPES.iter().find(|(known, _)| *known == name)?;
    let mut parts = Vec::new();
    collect(fields, &mut parts);
    let mut text = lines(fields);
    for (name, fields) in parts {
        text.push_str(&format!("{}\nMSG: {name}\n{}", "=".repeat(80), lines(fields)));
    }
    Some(text)
}

/// One line for each field.
fn lines(fields: &str) -> String {
    fields.split("; ").map(|field| format!("{field}\n")).collect()
}

/// Every type in these fields and below, each once.
fn collect(fields: &str, parts: &mut Vec<(&'static str, &'static str)>) {
    for field in fields.split("; ") {
        let of_field = field.split([' ', '[']).next();
        let part = TYPES.iter().find(|(name, _)| Some(*name) == of_field);
        if let Some(part) = part.filter(|part| !parts.contains(part)) {
            parts.push(*part);
            collect(part.1, parts);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::TopicRole;

    #[test]
    fn every_readable_type_has_a_complete_definition() {
        let readable = TopicRole::ALL.iter().flat_map(|role| role.type_names()).copied();
        // A type of ROS 1 is never written; its recordings have the definition.
        let readable = readable.filter(|name| *name != "tf/msg/tfMessage");
        for type_name in readable.chain(TYPES.iter().map(|(name, _)| *name)) {
            let text = definition(type_name).unwrap();
            for line in text.lines().filter(|line| line.contains('/') && !line.starts_with("MSG: ")) {
                let part = line.split([' ', '[']).next().unwrap();
                assert_eq!(text.matches(&format!("MSG: {part}\n")).count(), 1, "{type_name}: {part}");
            }
        }
        assert!(definition("std_msgs/msg/Char").is_none());
    }
}
