//! Joints by hand, and what is no robot.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::*;

/// A robot of these joints: name, type, parent, child and what stands between.
fn robot(joints: &[(&str, &str, &str, &str, &str)]) -> String {
    let joints: Vec<String> = joints
        .iter()
        .map(|(name, kind, parent, child, inside)| {
            format!(
                "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{inside}</joint>"
            )
        })
        .collect();
    format!("<robot name=\"r\">{}</robot>", joints.join("\n"))
}

fn pose_at(robot: &RobotDescription, joint: &str, positions: &[(&str, f64)]) -> Option<Isometry3<f64>> {
    let moved = robot.moved(positions.iter().copied());
    assert!(moved.unusable.is_none());
    moved.poses.iter().find(|(moved, _)| moved.name == joint).map(|(_, pose)| *pose)
}

#[test]
fn a_chain_by_hand() {
    let text = robot(&[
        ("yaw", "continuous", "base", "arm", "<origin xyz=\"0 0 1\"/><axis xyz=\"0 0 2\"/>"),
        ("slide", "prismatic", "arm", "hand", "<origin xyz='0.5 0 0' rpy='0 1.5707963267948966 0'/>"),
        ("tip", "fixed", "hand", "tip", "<origin xyz=\"0 0 0.1\"/>"),
    ]);
    let robot = RobotDescription::parse(&text).unwrap();
    assert_eq!(robot.root(), "base");
    let positions = [("yaw", FRAC_PI_2), ("slide", 0.2), ("wheel", 7.0)];
    let base_from_arm = pose_at(&robot, "yaw", &positions).unwrap();
    let arm_from_hand = pose_at(&robot, "slide", &positions).unwrap();
    assert!(pose_at(&robot, "tip", &[("tip", 1.0)]).is_none(), "fixed joints do not move");
    // The hand slides along its own x, which looks down at the arm: (0.5, 0, -0.2) there. The arm is a meter up and looks along y.
    let hand = base_from_arm * arm_from_hand * Point3::origin();
    assert!((hand - Point3::new(0.0, 0.5, 0.8)).norm() < 1e-12, "{hand}");
    // 0.1 m along the hand's z, which is the arm's x.
    let tip = base_from_arm * arm_from_hand * robot.joint("tip").unwrap().origin * Point3::origin();
    assert!((tip - Point3::new(0.0, 0.6, 0.8)).norm() < 1e-12, "{tip}");
}

#[test]
fn angles_of_an_origin_are_about_fixed_axes() {
    let rpy = robot(&[("a", "fixed", "b", "c", "<origin rpy=\"0.3 -0.4 2.0\"/>")]);
    let turn = |axis: Vector3<f64>, angle| UnitQuaternion::from_scaled_axis(axis * angle);
    let expected = turn(Vector3::z(), 2.0) * turn(Vector3::y(), -0.4) * turn(Vector3::x(), 0.3);
    let found = RobotDescription::parse(&rpy).unwrap().joints()[0].origin.rotation;
    assert!(found.angle_to(&expected) < 1e-12);
    let q = expected.quaternion();
    let quat = format!("<origin quat_xyzw=\"{} {} {} {}\"/>", q.i, q.j, q.k, q.w);
    let found =
        RobotDescription::parse(&robot(&[("a", "fixed", "b", "c", &quat)])).unwrap().joints()[0].origin;
    assert!(found.rotation.angle_to(&expected) < 1e-12);
}

#[test]
fn joints_that_mimic() {
    let text = robot(&[
        ("third", "prismatic", "b", "c", "<mimic joint=\"second\" multiplier=\"-3\" offset=\"0.5\"/>"),
        ("second", "prismatic", "a", "b", "<mimic joint=\"first\" multiplier=\"2\" offset=\"0.1\"/>"),
        ("first", "prismatic", "root", "a", ""),
    ]);
    let robot = RobotDescription::parse(&text).unwrap();
    let is_at = |joint: &str, positions: &[(&str, f64)], x_m: f64| {
        let pose = pose_at(&robot, joint, positions).unwrap();
        assert!((pose.translation.x - x_m).abs() < 1e-12, "{joint}: {pose}");
    };
    is_at("second", &[("first", 0.2)], 0.5);
    is_at("third", &[("first", 0.2)], -1.0);
    // Its own position wins.
    is_at("second", &[("first", 0.2), ("second", 0.3)], 0.3);
    assert!(pose_at(&robot, "second", &[("third", 0.2)]).is_none());
}

#[test]
fn positions_that_are_none() {
    let text = robot(&[
        ("good", "revolute", "root", "a", ""),
        ("bad", "revolute", "a", "b", ""),
        ("free", "floating", "b", "c", ""),
        ("loose", "revolute", "c", "d", "<axis xyz=\"0 0 0\"/>"),
    ]);
    let robot = RobotDescription::parse(&text).unwrap();
    for position in [f64::NAN, f64::INFINITY, -1e300] {
        let all = ["good", "bad", "free", "loose", "unknown"];
        let moved = robot.moved(all.map(|name| (name, if name == "good" { 1.0 } else { position })));
        assert_eq!(moved.poses.iter().map(|(joint, _)| joint.name.as_str()).collect::<Vec<_>>(), ["good"]);
        assert_eq!(moved.unusable.unwrap().0.name, "bad");
    }
    assert_eq!(robot.joint("free").unwrap().motion, JointMotion::Untold("floating".into()));
    assert!(
        matches!(&robot.joint("loose").unwrap().motion, JointMotion::Untold(kind) if kind.contains("axis"))
    );
}

#[test]
fn what_kinematics_does_not_need_is_passed_over() {
    let text = r#"<?xml version="1.0" encoding="utf-8"?>
<!-- ===================================================================================== -->
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro" version="1.0">
  <material name="gray"/>
  <link name="base">
    <visual><geometry><mesh filename="package://nowhere/base.dae" scale="1 1 1"/></geometry></visual>
    <inertial><mass value="nan"/></inertial>
  </link>
  <joint name="a" type="revolute">
    <parent link="/base"/><child link="tip"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="huge" effort="1" velocity="1"/><dynamics damping="?"/>
  </joint>
  <transmission name="t"><joint name="a"><hardwareInterface/></joint></transmission>
  <ros2_control name="c" type="system"><joint name="a"><command_interface name="position"/></joint></ros2_control>
  <gazebo reference="tip"><sensor type="camera"/></gazebo>
</robot>"#;
    let robot = RobotDescription::parse(text).unwrap();
    assert_eq!((robot.joints().len(), robot.root()), (1, "base"));
}

#[test]
fn what_is_no_robot_is_refused_with_its_place() {
    let joint = |inside: &str| robot(&[("a", "revolute", "b", "c", inside)]);
    let twice = [("a", "fixed", "b", "c", ""), ("a", "fixed", "c", "d", "")];
    let two_parents = [("x", "fixed", "b", "c", ""), ("y", "fixed", "d", "c", "")];
    let circle = [("x", "fixed", "b", "c", ""), ("y", "fixed", "c", "b", "")];
    let beside = [("x", "fixed", "b", "c", ""), ("y", "fixed", "d", "e", ""), ("z", "fixed", "e", "d", "")];
    let two_roots = [("x", "fixed", "b", "c", ""), ("y", "fixed", "d", "e", "")];
    let mimics = [
        ("x", "revolute", "b", "c", "<mimic joint=\"y\"/>"),
        ("y", "revolute", "c", "d", "<mimic joint=\"x\"/>"),
    ];
    for (text, expected) in [
        (String::new(), "expected a robot description"),
        ("<svg/>".into(), "found <svg>"),
        ("<robot name=\"r\"/>".into(), "expected a robot with joints, found none"),
        ("<robot><joint name=\"a\"".into(), "expected a robot description"),
        ("<robot>\n<joint type=\"fixed\"/></robot>".into(), "line 2: joint: expected name="),
        ("<robot><joint name=\"a\" type=\"fixed\"/></robot>".into(), "joint 'a': expected <parent link=...>"),
        (robot(&[("a", "hinge", "b", "c", "")]), "found 'hinge'"),
        (joint("<origin xyz=\"0 0\"/>"), "xyz: expected 3 numbers"),
        (joint("<origin xyz=\"0 0 nan\"/>"), "found '0 0 nan'"),
        (joint("<origin xyz=\"0 0 1e300\"/>"), "found '0 0 1e300'"),
        (joint("<origin rpy=\"0 0 0 0\"/>"), "rpy: expected 3 numbers"),
        (joint("<origin rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\"/>"), "found both"),
        (joint("<origin quat_xyzw=\"0 0 0 0\"/>"), "found zeros"),
        (joint("<axis xyz=\"up\"/>"), "<axis>: xyz: expected 3 numbers"),
        (joint("<mimic joint=\"d\"/>"), "mimics 'd', which is no joint"),
        (joint("<mimic joint=\"a\" multiplier=\"inf\"/>"), "multiplier"),
        (robot(&mimics), "in a circle"),
        (robot(&twice), "found two called 'a'"),
        (robot(&two_parents), "found a second: 'y'"),
        (robot(&circle), "in a circle"),
        (robot(&beside), "in a circle beside it"),
        (robot(&two_roots), "below 'b' and below 'd'"),
        (
            "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:macro name=\"m\"/></robot>".into(),
            "run xacro on it first",
        ),
    ] {
        let error = RobotDescription::parse(&text).unwrap_err();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn hostile_descriptions_cost_little() {
    let repeated = |what: &str, num| what.repeat(num);
    let many = |num: usize, kind: &str| {
        let joint = |i: usize| {
            format!(
                "<joint name=\"j{i}\" type=\"{kind}\"><parent link=\"l{i}\"/><child link=\"l{}\"/></joint>",
                i + 1
            )
        };
        format!("<robot>{}</robot>", (0..num).map(joint).collect::<String>())
    };
    let attributes: String = (0..100_000).map(|i| format!(" a{i}=\"\"")).collect();
    let spaces: String = (0..100_000).map(|i| format!("<a xmlns:n{i}=\"u{i}\">")).collect();
    let laughs = "<!DOCTYPE r [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;\">]><robot>&b;</robot>".to_owned();
    let long = "x".repeat(1 << 20);
    for text in [
        format!("<robot>{}", repeated("<a>", 100_000)),
        format!("<robot><joint{attributes}/></robot>"),
        format!("<robot>{spaces}</robot>"),
        laughs,
        many(501, "revolute"),
        many(4001, "fixed"),
        format!("<robot>{}</robot>", repeated("<a/>", 600_000)),
        format!("<robot>{}</robot>", repeated(" ", 9 << 20)),
        robot(&[(&long, "fixed", "b", "c", "")]),
        robot(&[("a", &long, "b", "c", "")]),
        robot(&[("a", "revolute", "b", "c", &format!("<origin xyz=\"{long}\"/>"))]),
        format!("<{long}/>"),
    ] {
        let error = RobotDescription::parse(&text).unwrap_err();
        assert!(error.len() < 400, "{} bytes: {}", text.len(), &error[..400]);
    }
    // As deep as it may be.
    let chain = RobotDescription::parse(&many(4000, "fixed")).unwrap();
    assert_eq!((chain.way_up("l4000").count(), chain.way_up("nowhere").count()), (4000, 0));
    assert_eq!(RobotDescription::parse(&many(500, "revolute")).unwrap().joints().len(), 500);
    let nested = format!("<robot>{}{}</robot>", repeated("<a>", 100_000), repeated("</a>", 100_000));
    assert_eq!(RobotDescription::parse(&nested).unwrap_err(), "expected a robot with joints, found none");
}
