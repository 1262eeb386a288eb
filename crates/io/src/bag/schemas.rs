//! Definitions of the messages that are written (`ros2msg`), complete with everything they contain, so that any tool
//! can decode a recording from the file alone.

/// One message definition: its name without `msg/`, its fields, the definitions it contains directly.
struct Definition {
    name: &'static str,
    fields: &'static str,
    parts: &'static [&'static Definition],
}

const TIME: Definition =
    Definition { name: "builtin_interfaces/Time", fields: "int32 sec\nuint32 nanosec\n", parts: &[] };
const HEADER: Definition = Definition {
    name: "std_msgs/Header",
    fields: "builtin_interfaces/Time stamp\nstring frame_id\n",
    parts: &[&TIME],
};
const POINT: Definition =
    Definition { name: "geometry_msgs/Point", fields: "float64 x\nfloat64 y\nfloat64 z\n", parts: &[] };
const VECTOR3: Definition =
    Definition { name: "geometry_msgs/Vector3", fields: "float64 x\nfloat64 y\nfloat64 z\n", parts: &[] };
const QUATERNION: Definition = Definition {
    name: "geometry_msgs/Quaternion",
    fields: "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
    parts: &[],
};
const POSE: Definition = Definition {
    name: "geometry_msgs/Pose",
    fields: "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    parts: &[&POINT, &QUATERNION],
};
const TWIST: Definition = Definition {
    name: "geometry_msgs/Twist",
    fields: "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
    parts: &[&VECTOR3],
};
const TRANSFORM: Definition = Definition {
    name: "geometry_msgs/Transform",
    fields: "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    parts: &[&VECTOR3, &QUATERNION],
};
const POSE_WITH_COVARIANCE: Definition = Definition {
    name: "geometry_msgs/PoseWithCovariance",
    fields: "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
    parts: &[&POSE],
};
const TWIST_WITH_COVARIANCE: Definition = Definition {
    name: "geometry_msgs/TwistWithCovariance",
    fields: "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
    parts: &[&TWIST],
};
const TRANSFORM_STAMPED: Definition = Definition {
    name: "geometry_msgs/TransformStamped",
    fields: "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    parts: &[&HEADER, &TRANSFORM],
};
const REGION_OF_INTEREST: Definition = Definition {
    name: "sensor_msgs/RegionOfInterest",
    fields: "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
    parts: &[],
};
const DIMENSION: Definition = Definition {
    name: "std_msgs/MultiArrayDimension",
    fields: "string label\nuint32 size\nuint32 stride\n",
    parts: &[],
};
const LAYOUT: Definition = Definition {
    name: "std_msgs/MultiArrayLayout",
    fields: "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n",
    parts: &[&DIMENSION],
};

const POSE_STAMPED: Definition = Definition {
    name: "geometry_msgs/PoseStamped",
    fields: "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    parts: &[&HEADER, &POSE],
};
const KEY_VALUE: Definition =
    Definition { name: "diagnostic_msgs/KeyValue", fields: "string key\nstring value\n", parts: &[] };
const DIAGNOSTIC_STATUS: Definition = Definition {
    name: "diagnostic_msgs/DiagnosticStatus",
    fields: "byte level\nstring name\nstring message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n",
    parts: &[&KEY_VALUE],
};
const POINT_FIELD: Definition = Definition {
    name: "sensor_msgs/PointField",
    fields: "string name\nuint32 offset\nuint8 datatype\nuint32 count\n",
    parts: &[],
};

const MESSAGES: [(&str, Definition); 17] = [
    (
        "sensor_msgs/msg/CompressedImage",
        Definition {
            name: "",
            fields: "std_msgs/Header header\nstring format\nuint8[] data\n",
            parts: &[&HEADER],
        },
    ),
    (
        "sensor_msgs/msg/Image",
        Definition {
            name: "",
            fields: "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 \
                     step\nuint8[] data\n",
            parts: &[&HEADER],
        },
    ),
    (
        "sensor_msgs/msg/CameraInfo",
        Definition {
            name: "",
            fields: "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\n\
                     float64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n\
                     sensor_msgs/RegionOfInterest roi\n",
            parts: &[&HEADER, &REGION_OF_INTEREST],
        },
    ),
    (
        "nav_msgs/msg/Odometry",
        Definition {
            name: "",
            fields: "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
                     geometry_msgs/TwistWithCovariance twist\n",
            parts: &[&HEADER, &POSE_WITH_COVARIANCE, &TWIST_WITH_COVARIANCE],
        },
    ),
    (
        "tf2_msgs/msg/TFMessage",
        Definition {
            name: "",
            fields: "geometry_msgs/TransformStamped[] transforms\n",
            parts: &[&TRANSFORM_STAMPED],
        },
    ),
    (
        "sensor_msgs/msg/JointState",
        Definition {
            name: "",
            fields: "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
            parts: &[&HEADER],
        },
    ),
    (
        "sensor_msgs/msg/Imu",
        Definition {
            name: "",
            fields: "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
                     geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
                     geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
            parts: &[&HEADER, &QUATERNION, &VECTOR3],
        },
    ),
    ("std_msgs/msg/String", Definition { name: "", fields: "string data\n", parts: &[] }),
    ("std_msgs/msg/Bool", Definition { name: "", fields: "bool data\n", parts: &[] }),
    (
        "std_msgs/msg/Float64MultiArray",
        Definition {
            name: "",
            fields: "std_msgs/MultiArrayLayout layout\nfloat64[] data\n",
            parts: &[&LAYOUT],
        },
    ),
    (
        "geometry_msgs/msg/PoseStamped",
        Definition {
            name: "",
            fields: "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
            parts: &[&HEADER, &POSE],
        },
    ),
    (
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        Definition {
            name: "",
            fields: "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n",
            parts: &[&HEADER, &POSE_WITH_COVARIANCE],
        },
    ),
    (
        "geometry_msgs/msg/PoseArray",
        Definition {
            name: "",
            fields: "std_msgs/Header header\ngeometry_msgs/Pose[] poses\n",
            parts: &[&HEADER, &POSE],
        },
    ),
    (
        "nav_msgs/msg/Path",
        Definition {
            name: "",
            fields: "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n",
            parts: &[&HEADER, &POSE_STAMPED],
        },
    ),
    ("std_msgs/msg/Float64", Definition { name: "", fields: "float64 data\n", parts: &[] }),
    (
        "diagnostic_msgs/msg/DiagnosticArray",
        Definition {
            name: "",
            fields: "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
            parts: &[&HEADER, &DIAGNOSTIC_STATUS],
        },
    ),
    (
        "sensor_msgs/msg/PointCloud2",
        Definition {
            name: "",
            fields: "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool \
                     is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
            parts: &[&HEADER, &POINT_FIELD],
        },
    ),
];

/// Definition of a message type with all it contains; `None` for a type that is never written.
#[must_use]
pub fn definition(type_name: &str) -> Option<String> {
    let (_, message) = MESSAGES.iter().find(|(name, _)| *name == type_name)?;
    let mut parts = Vec::new();
    collect(message, &mut parts);
    let mut text = message.fields.to_string();
    for part in parts {
        let line = "=".repeat(80);
        text.push_str(&format!("{line}\nMSG: {}\n{}", part.name, part.fields));
    }
    Some(text)
}

/// Every definition below `definition`, each once.
fn collect(definition: &Definition, parts: &mut Vec<&'static Definition>) {
    for part in definition.parts {
        if parts.iter().all(|known| known.name != part.name) {
            parts.push(part);
            collect(part, parts);
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
        for type_name in readable.chain(MESSAGES.iter().map(|(name, _)| *name)) {
            let text = definition(type_name).unwrap();
            for line in text.lines().filter(|line| line.contains('/') && !line.starts_with("MSG: ")) {
                let part = line.split([' ', '[']).next().unwrap();
                assert_eq!(text.matches(&format!("MSG: {part}\n")).count(), 1, "{type_name}: {part}");
            }
        }
        assert!(definition("std_msgs/msg/Char").is_none());
    }
}
