//! Robots that publish positions of joints in place of transforms.

use crate::{
    six_joints::{six_joints, with_joints},
    support::{MAP, Workspace, data_lines, excerpt, excerpt_text},
};

/// The numbers of a table, line by line.
fn numbers(workspace: &Workspace, name: &str) -> Vec<Vec<f64>> {
    let text = workspace.read(name);
    let lines = data_lines(&text).into_iter().skip(1);
    lines.map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect()
}

#[test]
fn joints_locate_the_robot_as_transforms_do() {
    let workspace = Workspace::new();
    with_joints(&excerpt("R1"), &workspace.path("joints.mcap"), 0);
    workspace.write("six.urdf", &six_joints());
    let localize = |source: &str, name: &str, more: &[&str]| {
        let words = ["localize", source, "--map", MAP, "--estimates", name];
        workspace.must(&[&words, more].concat());
        numbers(&workspace, name)
    };
    let by_transforms = localize(&excerpt_text("R1"), "tf.csv", &[]);
    let by_joints = localize("joints.mcap", "joints.csv", &[]);
    assert_eq!(by_joints.len(), by_transforms.len());
    // Rounding may move single pixels over a border.
    let mut apart: Vec<f64> =
        by_joints.iter().zip(&by_transforms).map(|(a, b)| (a[1] - b[1]).hypot(a[2] - b[2])).collect();
    apart.sort_by(f64::total_cmp);
    assert!(apart[apart.len() * 9 / 10] < 0.001, "{apart:?}");
    // What the bag says itself is the same as what the user says.
    assert_eq!(localize("joints.mcap", "given.csv", &["--urdf", "six.urdf"]), by_joints);
    // A copy has the joints; one of less has their poses as transforms.
    workspace.must(&["record", "joints.mcap", "--out", "copy.mcap"]);
    assert_eq!(localize("copy.mcap", "copied.csv", &[]), by_joints);
    workspace.must(&["record", "joints.mcap", "--urdf", "six.urdf", "--frames", "3", "--out", "less.mcap"]);
    assert_eq!(localize("less.mcap", "less.csv", &[]).len(), 3);
}

#[test]
fn a_description_is_asked_for_and_joints_without_positions_are_named() {
    let workspace = Workspace::new();
    with_joints(&excerpt("R1"), &workspace.path("joints.mcap"), 0);
    workspace.write("topics.toml", "robot_description = \"\"\n");
    let localize = ["localize", "joints.mcap", "--map", MAP];
    let error = |more: &[&str]| workspace.refused(&[&localize[..], more].concat());
    let said = error(&["--topics", "topics.toml"]);
    assert!(said.contains("'/tf'") && said.contains("--urdf FILE"), "{said}");
    let other = six_joints().replace("name=\"yaw\"", "name=\"neck\"");
    workspace.write("other.urdf", &other);
    workspace.write("six.urdf", &six_joints());
    let said = error(&["--urdf", "other.urdf"]);
    assert!(said.contains("no positions have come of the joints 'neck'"), "{said}");
    let said = error(&["--urdf", "six.urdf", "--camera-height", "0.5"]);
    assert!(said.contains("--urdf") && said.contains("--camera-height is used in place of it"), "{said}");
}
