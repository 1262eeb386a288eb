//! A recording whose robot publishes positions of joints in place of transforms. The tests of the program take this file over.

use std::{collections::BTreeMap, f64::consts::FRAC_PI_2, path::Path, sync::Arc};

use nalgebra::{Quaternion, UnitQuaternion};
use visloc_core::geom::nao::body_from_optical;
use visloc_io::bag::{
    BagMessage, BagMessages, BagTopics, BagWriter, Channel, definition,
    messages::{self, from_cdr, to_cdr},
};

/// Six joints that reach every pose of the camera, one after the other.
pub fn six_joints() -> String {
    let names = ["x", "y", "z", "yaw", "pitch", "roll"];
    let axes = ["1 0 0", "0 1 0", "0 0 1", "0 0 1", "0 1 0", "1 0 0"];
    let mut joints = String::new();
    for (i, (name, axis)) in names.into_iter().zip(axes).enumerate() {
        let kind = if i < 3 { "prismatic" } else { "continuous" };
        let parent = if i == 0 { "base_footprint" } else { names[i - 1] };
        joints += &format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{name}\"/><axis xyz=\"{axis}\"/></joint>\n"
        );
    }
    joints += &format!(
        "<joint name=\"optical\" type=\"fixed\"><parent link=\"roll\"/><child link=\"camera_optical\"/>\
         <origin rpy=\"-{FRAC_PI_2} 0 -{FRAC_PI_2}\"/></joint>\n"
    );
    format!("<?xml version=\"1.0\"?>\n<robot name=\"six\">\n{joints}</robot>\n")
}

/// The positions of [`six_joints`] for a pose of the camera.
fn six_positions(pose: &messages::Pose) -> messages::JointState {
    let (t, q) = (&pose.position, &pose.orientation);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z)).to_rotation_matrix();
    let (roll, pitch, yaw) = (rotation * body_from_optical().inverse()).euler_angles();
    messages::JointState {
        name: ["x", "y", "z", "yaw", "pitch", "roll", "gripper"].map(Into::into).into(),
        position: vec![t.x, t.y, t.z, yaw, pitch, roll, f64::NAN],
        ..messages::JointState::default()
    }
}

/// Copies an excerpt with positions of joints in place of transforms; the description stands behind `num_before` other messages.
pub fn with_joints(from: &Path, to: &Path, num_before: usize) {
    let channel = |topic: &str, type_name: &str| {
        Arc::new(Channel {
            topic: topic.into(),
            type_name: type_name.into(),
            message_encoding: "cdr".into(),
            schema_encoding: "ros2msg".into(),
            schema: definition(type_name).unwrap().into_bytes(),
            metadata: BTreeMap::new(),
        })
    };
    let states = channel("/joint_states", "sensor_msgs/msg/JointState");
    let described = channel("/robot_description", "std_msgs/msg/String");
    let mut bag = BagMessages::open(from).unwrap();
    let mut writer = BagWriter::create(to, BagTopics::default()).unwrap();
    let mut num_copied = 0;
    while let Some(message) = bag.next_message() {
        let mut message = message.unwrap();
        if num_copied == num_before {
            let data = to_cdr(&messages::StringMessage { data: six_joints() }).unwrap();
            let description = BagMessage { channel: described.clone(), data, ..message.clone() };
            writer.write_copy(&description).unwrap();
        }
        num_copied += 1;
        if message.channel.topic == "/tf" {
            let tf: messages::TfMessage = from_cdr(&message.data).unwrap();
            let [transform] = &tf.transforms[..] else { panic!("{tf:?}") };
            assert_eq!(
                (transform.header.frame_id.as_str(), transform.child_frame_id.as_str()),
                ("base_footprint", "camera_optical")
            );
            let state = messages::JointState {
                header: transform.header.clone(),
                ..six_positions(&transform.transform)
            };
            message.data = to_cdr(&state).unwrap();
            message.channel = states.clone();
        }
        writer.write_copy(&message).unwrap();
    }
    writer.finish().unwrap();
}
