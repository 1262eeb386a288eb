//! Descriptions of robots.

use std::sync::Arc;

use visloc_core::Timestamp;
use visloc_io::{
    bag::{BagTopics, ExpectedInputs, SensorMessage, Synchronizer},
    urdf::{RobotDescription, read_robot_description},
};

use super::as_file;

/// Every kind of joint, and feet to stand on; what comes last is a number that counts.
pub const ROBOT: &str = r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <link name="base_link"><visual><geometry><mesh filename="a.dae"/></geometry></visual></link>
  <joint name="left" type="prismatic">
    <parent link="base_link"/><child link="l_sole"/><origin xyz="0 0.05 -0.3"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="right" type="prismatic">
    <parent link="base_link"/><child link="r_sole"/><origin xyz="0 -0.05 -0.3"/><axis xyz="0 0 1"/>
    <mimic joint="left" multiplier="-1" offset="0.01"/>
  </joint>
  <joint name="tail" type="floating"><parent link="base_link"/><child link="tail"/></joint>
  <transmission name="t"><joint name="neck"/></transmission>
  <joint name="eye" type="fixed">
    <parent link="head"/><child link="camera_optical"/><origin xyz="0.05 0 0.1" rpy="-1.57 0 -1.57"/>
  </joint>
  <joint name="neck" type="revolute">
    <parent link="base_link"/><child link="head"/><limit lower="-1" upper="1"/><axis xyz="0 0 1"/>
  </joint>
</robot>
"#;

pub fn seeds() -> Vec<Vec<u8>> {
    let joints: String = (0..60)
        .map(|i| {
            format!(
                "<joint name=\"{i}\" type=\"continuous\"><parent link=\"l{i}\"/><child link=\"l{}\"/>\
                 <origin quat_xyzw=\"0 0 0.6 0.8\"/></joint>",
                i + 1
            )
        })
        .collect();
    vec![ROBOT.into(), format!("<robot name=\"long\">{joints}</robot>").into_bytes()]
}

/// Reads a robot and moves its joints, as a source does.
pub fn read(bytes: &[u8]) {
    let Ok(robot) = as_file("robot.urdf", bytes, read_robot_description) else { return };
    for link in robot.joints().iter().map(|joint| joint.child.as_str()) {
        assert!(robot.way_up(link).count() <= robot.joints().len(), "a circle above {link}");
    }
    let positions = |position: f64| robot.joints().iter().map(move |joint| (joint.name.as_str(), position));
    for position in [0.5, 1e6, f64::NAN] {
        for (joint, pose) in robot.moved(positions(position)).poses {
            assert!(pose.to_homogeneous().iter().all(|number| number.is_finite()), "{}", joint.name);
        }
    }
    let mut synchronizer = Synchronizer::new(&BagTopics::default(), ExpectedInputs::default());
    let owned: Vec<_> = positions(0.5).map(|(name, position)| (name.to_owned(), position)).collect();
    let robot: Arc<RobotDescription> = Arc::new(robot);
    synchronizer.push(SensorMessage::RobotDescription(robot));
    for i in 0..3 {
        synchronizer.push(SensorMessage::JointStates(Timestamp::from_nanos(i), owned.clone()));
    }
}
