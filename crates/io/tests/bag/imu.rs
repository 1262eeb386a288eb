//! Robots whose trunk tilts, by an IMU.

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use visloc_core::{
    Timestamp,
    geom::{Camera, CameraFrame, Rigid3, Robot},
};
use visloc_io::bag::{
    BagTopics, ExpectedInputs, RosMessage, SensorMessage, StampedTransform, SyncOutcome, Synchronizer,
    messages::{Header, Imu, Quaternion},
};

use crate::support::picture;

fn at(secs: f64) -> Timestamp {
    Timestamp::from_secs(100.0 + secs)
}

fn image(secs: f64) -> SensorMessage {
    picture(at(secs))
}

fn turn(roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> UnitQuaternion<f64> {
    let [roll, pitch, yaw] = [roll_deg, pitch_deg, yaw_deg].map(f64::to_radians);
    UnitQuaternion::from_euler_angles(roll, pitch, yaw)
}

fn fixed(parent: &str, child: &str, xyz: [f64; 3], rotation: UnitQuaternion<f64>) -> StampedTransform {
    let parent_from_child = Isometry3::from_parts(Vector3::from(xyz).into(), rotation);
    StampedTransform { at: at(0.0), parent: parent.into(), child: child.into(), parent_from_child }
}

fn imu(secs: f64, world_from_imu: UnitQuaternion<f64>) -> SensorMessage {
    SensorMessage::Imu(at(secs), "imu_link".into(), world_from_imu)
}

/// Where the camera is on a robot whose frames say that it is level.
const CAMERA_M: [f64; 3] = [0.1, 0.02, 0.5];
fn camera_turn() -> UnitQuaternion<f64> {
    turn(-90.0, 0.0, -90.0) * turn(3.0, 0.0, 0.0)
}

/// A synchronizer that waits for an IMU which is mounted like this.
fn synchronizer(base_from_imu: UnitQuaternion<f64>) -> Synchronizer {
    let topics = BagTopics { imu: "/imu/data".into(), ..BagTopics::default() };
    let expected = ExpectedInputs { has_imu: true, ..ExpectedInputs::default() };
    let mut synchronizer = Synchronizer::new(&topics, expected);
    let camera = Camera::pinhole((64, 48), (70.0, 70.0), (31.5, 23.5)).unwrap();
    synchronizer.push(SensorMessage::CameraInfo(at(0.0), camera));
    synchronizer.push(SensorMessage::StaticTransforms(vec![
        fixed("base_footprint", "camera", CAMERA_M, camera_turn()),
        fixed("base_footprint", "imu_link", [0.0, 0.0, 0.3], base_from_imu),
    ]));
    synchronizer
}

fn next_pose(synchronizer: &mut Synchronizer) -> Option<Rigid3<Robot, CameraFrame>> {
    match synchronizer.pop()? {
        SyncOutcome::Frame(frame) => Some(frame.source_frame.frame.robot_from_camera),
        SyncOutcome::Unusable(reason) => panic!("{reason}"),
    }
}

#[test]
fn a_trunk_that_tilts_takes_the_camera_with_it() {
    // Upside down and across, as some are mounted.
    for base_from_imu in [turn(0.0, 0.0, 0.0), turn(180.0, 0.0, 90.0), turn(0.0, 12.0, -30.0)] {
        for (roll_deg, pitch_deg) in [(0.0, 8.0), (-5.0, 0.0), (4.0, -6.0)] {
            let mut synchronizer = synchronizer(base_from_imu);
            // Which way the robot looks is not what an IMU is asked for.
            for (secs, yaw_deg) in [(0.0, 70.0), (0.2, 110.0)] {
                synchronizer.push(imu(secs, turn(roll_deg, pitch_deg, yaw_deg) * base_from_imu));
            }
            synchronizer.push(image(0.1));
            let pose = next_pose(&mut synchronizer).unwrap();
            let tilted = turn(roll_deg, pitch_deg, 0.0);
            let (up, expected_up) = (pose.rotation().tr_mul(&Vector3::z()), {
                let world_from_camera = tilted * camera_turn();
                world_from_camera.inverse() * Vector3::z()
            });
            assert!((up - expected_up).norm() < 1e-9, "{roll_deg} {pitch_deg}: {up} {expected_up}");
            let expected_z = (tilted * Vector3::from(CAMERA_M)).z;
            assert!((pose.translation().z - expected_z).abs() < 1e-9);
            // The robot still looks ahead.
            let ahead = Rotation3::from_matrix_unchecked(*pose.rotation()) * Vector3::z();
            assert!(ahead.y.atan2(ahead.x).abs() < 0.02, "{ahead}");
        }
    }
}

#[test]
fn images_wait_for_the_tilt_of_their_moment() {
    let mut synchronizer = synchronizer(turn(0.0, 0.0, 0.0));
    synchronizer.push(imu(0.0, turn(0.0, 0.0, 0.0)));
    synchronizer.push(image(0.05));
    assert!(next_pose(&mut synchronizer).is_none());
    synchronizer.push(imu(0.1, turn(0.0, 10.0, 0.0)));
    let pose = next_pose(&mut synchronizer).unwrap();
    let ahead = pose.rotation() * Vector3::z();
    let level = camera_turn() * Vector3::z();
    let tilt_deg = (level.z.asin() - ahead.z.asin()).to_degrees();
    assert!((tilt_deg - 5.0).abs() < 0.1, "half of the way: {tilt_deg}");
    // Without an IMU for half a second nothing tells where the camera is.
    synchronizer.push(image(0.7));
    synchronizer.finish();
    assert!(next_pose(&mut synchronizer).is_none());
    let reason = &synchronizer.skipped().last().unwrap().reason;
    assert!(reason.contains("expected a message of the IMU within 0.5 s"), "{reason}");
}

#[test]
fn an_imu_that_tells_no_orientation_or_is_nowhere_is_refused() {
    let header = Header::new(at(0.0), "imu_link");
    let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    let mut raw = Imu { header, orientation, ..Imu::default() };
    let mut rejects = Vec::new();
    assert!(RosMessage::Imu(raw.clone()).sensed(at(0.0), &mut rejects).is_some());
    raw.orientation_covariance[0] = -1.0;
    assert!(RosMessage::Imu(raw).sensed(at(0.0), &mut rejects).is_none());
    assert!(rejects[0].is_fatal && rejects[0].reason.contains("expected an IMU with an orientation"));

    let mut synchronizer = synchronizer(turn(0.0, 0.0, 0.0));
    for secs in [0.0, 0.2] {
        synchronizer.push(SensorMessage::Imu(at(secs), "elsewhere".into(), turn(0.0, 0.0, 0.0)));
    }
    synchronizer.push(image(0.1));
    assert!(next_pose(&mut synchronizer).is_none());
    let reason = &synchronizer.skipped().last().unwrap().reason;
    assert!(reason.contains("a transform to the frame of the IMU, 'elsewhere'"), "{reason}");
}
