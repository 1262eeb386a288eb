//! Robots that publish positions of joints in place of transforms.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use tempfile::TempDir;
use visloc_core::{
    Timestamp,
    geom::{
        Camera, CameraFrame, Rigid3, Robot,
        nao::{self, HeadAngles, NaoCamera, Torso},
    },
};
use visloc_io::{
    bag::{
        BagReader, BagTopics, ExpectedInputs, GivenInputs, SensorMessage, StampedTransform, SyncOutcome,
        Synchronizer,
    },
    urdf::RobotDescription,
};

use crate::{
    six_joints::{six_joints, with_joints},
    support::{picture, read_with, testdata},
};

const HALF_TURN: f64 = std::f64::consts::FRAC_PI_2;

fn joint(name: &str, kind: &str, links: (&str, &str), xyz: [f64; 3], rpy: [f64; 3], axis: &str) -> String {
    let (parent, child) = links;
    let words = |numbers: [f64; 3]| numbers.map(|number| format!("{number:?}")).join(" ");
    let (xyz, rpy) = (words(xyz), words(rpy));
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/></joint>\n"
    )
}

/// Head and legs of a Nao, by the numbers of its maker, with the frames of REP 120.
fn nao_urdf(with_legs: bool) -> String {
    let zero = [0.0; 3];
    let camera = NaoCamera::TopV4;
    let neck = [0.0, 0.0, nao::NECK_OFFSET_Z_M];
    let mut joints = vec![
        joint("trunk", "fixed", ("base_link", "torso"), zero, zero, "1 0 0"),
        joint("HeadYaw", "revolute", ("torso", "Neck"), neck, zero, "0 0 1"),
        joint("HeadPitch", "revolute", ("Neck", "Head"), zero, zero, "0 1 0"),
        joint(
            "eye",
            "fixed",
            ("Head", "CameraTop"),
            camera.offset_m().into(),
            [0.0, camera.pitch_rad(), 0.0],
            "1 0 0",
        ),
        joint("axes", "fixed", ("CameraTop", "camera"), zero, [-HALF_TURN, 0.0, -HALF_TURN], "1 0 0"),
    ];
    let [hip, thigh, tibia, foot] = nao::LEG_LENGTHS_M;
    for (side, y) in [("L", 0.05), ("R", -0.05)].into_iter().filter(|_| with_legs) {
        let link = |part: &str| format!("{side}{part}");
        let sole = format!("{}_sole", side.to_lowercase());
        for (name, kind, parent, child, at) in [
            ("HipPitch", "revolute", "torso".to_owned(), link("Thigh"), [0.0, y, -hip]),
            ("KneePitch", "revolute", link("Thigh"), link("Tibia"), [0.0, 0.0, -thigh]),
            ("AnklePitch", "revolute", link("Tibia"), link("Foot"), [0.0, 0.0, -tibia]),
            ("Sole", "fixed", link("Foot"), sole, [0.0, 0.0, -foot]),
        ] {
            joints.push(joint(&link(name), kind, (&parent, &child), at, zero, "0 1 0"));
        }
    }
    format!("<robot name=\"nao\">{}</robot>", joints.concat())
}

fn at(secs: f64) -> Timestamp {
    Timestamp::from_secs(100.0 + secs)
}

fn image(secs: f64) -> SensorMessage {
    picture(at(secs))
}

fn positions(secs: f64, positions: &[(&str, f64)]) -> SensorMessage {
    let named = positions.iter().map(|(name, position)| ((*name).to_owned(), *position));
    SensorMessage::JointStates(at(secs), named.collect())
}

/// A synchronizer that knows camera and robot.
fn synchronizer(urdf: &str, topics: &BagTopics) -> Synchronizer {
    let mut synchronizer = Synchronizer::new(topics, ExpectedInputs::default());
    let camera = Camera::pinhole((64, 48), (70.0, 70.0), (31.5, 23.5)).unwrap();
    synchronizer.push(SensorMessage::CameraInfo(at(0.0), camera));
    let robot = RobotDescription::parse(urdf).unwrap();
    synchronizer.push(SensorMessage::RobotDescription(Arc::new(robot)));
    synchronizer
}

/// The camera's pose in the frames that are complete.
fn poses(synchronizer: &mut Synchronizer) -> Vec<Rigid3<Robot, CameraFrame>> {
    let mut poses = Vec::new();
    while let Some(outcome) = synchronizer.pop() {
        match outcome {
            SyncOutcome::Frame(frame) => poses.push(frame.source_frame.frame.robot_from_camera),
            SyncOutcome::Unusable(reason) => panic!("{reason}"),
        }
    }
    poses
}

fn distance(a: &Rigid3<Robot, CameraFrame>, b: &Rigid3<Robot, CameraFrame>) -> f64 {
    (a.translation() - b.translation()).norm() + (a.rotation() - b.rotation()).norm()
}

/// Legs that bend by `bend` below a torso that leans by `lean`, both feet flat.
fn crouching(bend: f64, lean: f64, head: HeadAngles) -> Vec<(&'static str, f64)> {
    vec![
        ("HeadYaw", head.yaw_rad),
        ("HeadPitch", head.pitch_rad),
        ("LHipPitch", -bend - lean),
        ("RHipPitch", -bend - lean),
        ("LKneePitch", 2.0 * bend),
        ("RKneePitch", 2.0 * bend),
        ("LAnklePitch", -bend),
        ("RAnklePitch", -bend),
    ]
}

/// Where the camera is by the chain of the library, the torso's place by hand.
fn expected_pose(bend: f64, lean: f64, head: HeadAngles) -> Rigid3<Robot, CameraFrame> {
    let [hip, thigh, tibia, foot] = nao::LEG_LENGTHS_M;
    let height_m = hip * lean.cos() + (thigh + tibia) * bend.cos() + foot;
    let torso = Torso { height_m, roll_rad: 0.0, pitch_rad: lean };
    let pose = nao::robot_from_camera(&torso, &head, NaoCamera::TopV4);
    let ahead_m = hip * lean.sin() + (tibia - thigh) * bend.sin();
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(*pose.rotation());
    Rigid3::new(rotation, pose.translation() + Vector3::x() * ahead_m)
}

#[test]
fn a_robot_with_feet_stands_on_them() {
    let head = HeadAngles { yaw_rad: 0.7, pitch_rad: 0.2 };
    for (bend, lean) in [(0.0, 0.0), (0.4, 0.0), (0.5, 0.15), (0.3, -0.1)] {
        let mut synchronizer = synchronizer(&nao_urdf(true), &BagTopics::default());
        synchronizer.push(positions(0.1, &crouching(bend, lean, head)));
        synchronizer.push(image(0.1));
        let found = poses(&mut synchronizer);
        let expected = expected_pose(bend, lean, head);
        assert!(distance(&found[0], &expected) < 1e-9, "{bend} {lean}: {found:?}, {expected:?}");
        assert!(synchronizer.skipped().is_empty());
    }
    // One foot is lifted, and both are ahead of the torso by different lengths: the lower one counts for height and level.
    let mut synchronizer = synchronizer(&nao_urdf(true), &BagTopics::default());
    let mut lifted = crouching(0.0, 0.0, head);
    for (name, position) in &mut lifted {
        match *name {
            "RHipPitch" => *position = -0.8,
            "RKneePitch" => *position = 1.0,
            _ => {}
        }
    }
    synchronizer.push(positions(0.1, &lifted));
    synchronizer.push(image(0.1));
    let found = poses(&mut synchronizer)[0];
    let standing = nao::robot_from_camera(&Torso::upright(), &head, NaoCamera::TopV4);
    assert!((found.rotation() - standing.rotation()).norm() < 1e-9);
    assert!((found.translation().z - standing.translation().z).abs() < 1e-9);
    let moved = found.translation() - standing.translation();
    assert!(moved.y.abs() < 1e-9 && moved.x.abs() > 0.01 && moved.x.abs() < 0.1, "{moved}");
}

#[test]
fn positions_are_interpolated_as_transforms_are_and_come_in_parts() {
    let mut synchronizer = synchronizer(&nao_urdf(true), &BagTopics::default());
    let head = |yaw_rad| HeadAngles { yaw_rad, pitch_rad: 0.0 };
    let all = crouching(0.3, 0.0, head(0.0));
    let (neck, legs) = all.split_at(2);
    synchronizer.push(positions(0.0, legs));
    synchronizer.push(positions(0.0, neck));
    synchronizer.push(image(0.05));
    assert!(poses(&mut synchronizer).is_empty(), "it waits for what comes after it");
    synchronizer.push(positions(0.1, legs));
    synchronizer.push(positions(0.1, &[("HeadYaw", 0.4), ("HeadPitch", 0.0)]));
    let found = poses(&mut synchronizer);
    assert!(distance(&found[0], &expected_pose(0.3, 0.0, head(0.2))) < 1e-9, "{found:?}");
}

#[test]
fn transforms_win_over_joints() {
    let mut synchronizer = synchronizer(&nao_urdf(true), &BagTopics::default());
    let head = HeadAngles { yaw_rad: 0.3, pitch_rad: 0.1 };
    let tf = |secs, parent: &str, child: &str, height_m| StampedTransform {
        at: at(secs),
        parent: parent.into(),
        child: child.into(),
        parent_from_child: Isometry3::translation(0.0, 0.0, height_m),
    };
    synchronizer.push(positions(0.1, &crouching(0.4, 0.0, head)));
    // Somebody knows better how high the trunk is: the frame on the ground is its parent, not its child.
    synchronizer.push(SensorMessage::Transforms(vec![tf(0.1, "base_footprint", "base_link", 0.3)]));
    synchronizer.push(positions(0.1, &crouching(0.4, 0.0, head)));
    synchronizer.push(image(0.1));
    let torso = Torso { height_m: 0.3, roll_rad: 0.0, pitch_rad: 0.0 };
    let expected = nao::robot_from_camera(&torso, &head, NaoCamera::TopV4);
    assert!(distance(&poses(&mut synchronizer)[0], &expected) < 1e-9);
    // And where the camera is.
    synchronizer.push(SensorMessage::Transforms(vec![tf(0.2, "base_footprint", "camera", 1.5)]));
    synchronizer.push(positions(0.2, &crouching(0.4, 0.0, head)));
    synchronizer.push(image(0.2));
    let found = poses(&mut synchronizer)[0];
    assert!((found.translation() - Vector3::new(0.0, 0.0, 1.5)).norm() < 1e-9, "{found:?}");
}

#[test]
fn a_frame_on_the_ground_may_hang_below_the_trunk_and_carry_others() {
    let zero = [0.0; 3];
    let urdf = [
        joint("lift", "prismatic", ("base_link", "base_footprint"), [0.0, 0.0, -0.4], zero, "0 0 -1"),
        joint("caster", "fixed", ("base_footprint", "caster"), zero, zero, "1 0 0"),
        joint("mast", "fixed", ("base_link", "camera"), [0.0, 0.0, 0.2], zero, "1 0 0"),
    ];
    let mut synchronizer =
        synchronizer(&format!("<robot name=\"r\">{}</robot>", urdf.concat()), &BagTopics::default());
    synchronizer.push(positions(0.1, &[("lift", 0.1)]));
    synchronizer.push(image(0.1));
    let found = poses(&mut synchronizer);
    assert!((found[0].translation() - Vector3::new(0.0, 0.0, 0.7)).norm() < 1e-9, "{found:?}");
}

#[test]
fn what_is_missing_is_said() {
    let reason = |synchronizer: &mut Synchronizer| {
        synchronizer.push(image(0.1));
        synchronizer.finish();
        assert!(poses(synchronizer).is_empty());
        synchronizer.skipped().last().unwrap().reason.clone()
    };
    let head = [("HeadYaw", 0.0), ("HeadPitch", 0.0)];
    let mut without_legs = synchronizer(&nao_urdf(false), &BagTopics::default());
    without_legs.push(positions(0.1, &head));
    let said = reason(&mut without_legs);
    assert!(
        said.contains("'base_link'") && said.contains("--base-frame") && said.contains("--camera-height"),
        "{said}"
    );
    // A frame of the description that is named is used.
    let topics = BagTopics { base_frame: "base_link".into(), ..BagTopics::default() };
    let mut named = synchronizer(&nao_urdf(false), &topics);
    named.push(positions(0.1, &head));
    named.push(image(0.1));
    let height_m = poses(&mut named)[0].translation().z;
    assert!((height_m - nao::NECK_OFFSET_Z_M - 0.06364).abs() < 1e-9);
    let mut still = synchronizer(&nao_urdf(true), &BagTopics::default());
    still.push(positions(0.1, &head));
    let said = reason(&mut still);
    assert!(said.contains("no positions have come of the joints") && said.contains("'LHipPitch'"), "{said}");
    let mut undescribed = Synchronizer::new(&BagTopics::default(), ExpectedInputs::default());
    let camera = Camera::pinhole((64, 48), (70.0, 70.0), (31.5, 23.5)).unwrap();
    undescribed.push(SensorMessage::CameraInfo(at(0.0), camera));
    undescribed.push(positions(0.1, &head));
    let said = reason(&mut undescribed);
    assert!(said.contains("--urdf FILE"), "{said}");
}

#[test]
fn what_cannot_be_used_is_counted() {
    let zero = [0.0; 3];
    let urdf = [
        joint("world", "floating", ("world", "base_footprint"), zero, zero, "1 0 0"),
        joint("neck", "revolute", ("base_footprint", "camera"), zero, zero, "0 0 1"),
    ];
    let urdf = format!("<robot name=\"r\">{}</robot>", urdf.concat());
    let mut synchronizer = synchronizer(&urdf, &BagTopics::default());
    let robot = Arc::new(RobotDescription::parse(&urdf).unwrap());
    synchronizer.push(SensorMessage::RobotDescription(robot));
    for i in 0..3 {
        let position = if i == 1 { f64::NAN } else { 0.1 };
        synchronizer.push(positions(0.1 * f64::from(i), &[("neck", position), ("finger", f64::NAN)]));
    }
    let said: Vec<_> =
        synchronizer.skipped().iter().map(|skip| (skip.origin.as_str(), &skip.reason)).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[0].0 == "/robot_description" && said[0].1.contains("'world' is floating"), "{said:?}");
    assert!(
        said[1].0 == "/joint_states" && said[1].1.contains("'neck'") && said[1].1.contains("NaN"),
        "{said:?}"
    );
}

#[test]
fn joints_give_the_same_camera_as_transforms() {
    let folder = TempDir::new().unwrap();
    for (name, num_before) in [("R1-excerpt.mcap", 0), ("R2-excerpt.mcap", 100)] {
        let path = folder.path().join(name);
        with_joints(&testdata(name), &path, num_before);
        let by_transforms = read_with(BagReader::open(testdata(name), BagTopics::default()).unwrap());
        let by_joints = read_with(BagReader::open(&path, BagTopics::default()).unwrap());
        assert!(by_joints.error.is_none() && by_joints.skipped.is_empty(), "{:?}", by_joints.skipped);
        assert_eq!(by_joints.frames.len(), by_transforms.frames.len());
        for (a, b) in by_joints.frames.iter().zip(&by_transforms.frames) {
            let apart = distance(&a.frame.robot_from_camera, &b.frame.robot_from_camera);
            assert!(apart < 1e-9, "{}: {apart}", a.frame.at);
            assert_eq!((a.frame.at, a.frame.odometry), (b.frame.at, b.frame.odometry));
        }
        // The same with the description from elsewhere.
        let topics = BagTopics { robot_description: String::new(), ..BagTopics::default() };
        let Err(error) = BagReader::open(&path, topics.clone()) else { panic!("opened") };
        assert!(error.to_string().contains("--urdf FILE"), "{error}");
        let robot = Arc::new(RobotDescription::parse(&six_joints()).unwrap());
        let given = GivenInputs { robot: Some(robot), ..GivenInputs::default() };
        let given = read_with(BagReader::open_with(&path, &topics, given).unwrap());
        assert_eq!(given.frames.len(), by_joints.frames.len());
        for (a, b) in given.frames.iter().zip(&by_joints.frames) {
            assert_eq!(a.frame.robot_from_camera, b.frame.robot_from_camera);
        }
    }
}
