//! Corrections and the odometry fit against motions with known factors.

use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use visloc_core::{
    RngTree, Timestamp, gaussian,
    geom::{PlanarPose, Rigid3},
};

use super::{record::DrivePoint, *};

#[test]
fn odometry_factors_come_back() {
    let truth = OdometryCorrection { scale: [0.91, 1.08, 1.1], drift_deg_per_m: 2.0 };
    let mut rng = RngTree::new(3).stream("odometry", 0);
    let mut record = DriveRecord::default();
    let (mut odometry, mut pose) = (PlanarPose::default(), PlanarPose::default());
    let mut motion = PlanarPose::default();
    for i in 0..1200 {
        if i % 60 == 0 {
            let mut draw = |from: f64, to: f64| rng.random_range(from..to);
            motion = PlanarPose::new(draw(-0.004, 0.012), draw(-0.006, 0.006), draw(-0.03, 0.03));
        }
        odometry = odometry.compose(&motion);
        pose = pose.compose(&truth.apply(&motion));
        let noise = |rng: &mut visloc_core::Rng, sigma| gaussian(rng, sigma);
        let seen = PlanarPose::new(
            pose.x_m + noise(&mut rng, 0.01),
            pose.y_m + noise(&mut rng, 0.01),
            pose.yaw_rad + noise(&mut rng, 0.005),
        );
        // For some seconds nobody knows the place, and once the robot is carried away.
        let is_known = !(300..360).contains(&i);
        if i == 700 {
            pose = PlanarPose::new(1.0, 1.0, 2.0);
        }
        record.points.push(DrivePoint {
            at: Timestamp::from_secs(f64::from(i) / 30.0),
            world_from_robot: is_known.then_some(seen),
            odometry: Some(odometry),
        });
    }
    let found = solve_odometry(&record).unwrap();
    for (factor, expected) in found.correction.scale.into_iter().zip(truth.scale) {
        assert!((factor - expected).abs() < 0.02, "{found:?}");
    }
    assert!((found.correction.drift_deg_per_m - 2.0).abs() < 1.0, "{found:?}");
}

#[test]
fn corrector_gives_the_corrected_path() {
    let correction = OdometryCorrection { scale: [2.0, 1.0, 1.0], drift_deg_per_m: 0.0 };
    let mut corrector = OdometryCorrector::default();
    let start = PlanarPose::new(1.0, 0.0, 0.0);
    assert_eq!(corrector.step(&start, &correction), start);
    let end = corrector.step(&PlanarPose::new(2.0, 0.0, 0.0), &correction);
    assert!((end.x_m - 3.0).abs() < 1e-12);
}

#[test]
fn a_camera_that_looks_down_sees_lower() {
    let ahead = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0,
    ));
    let reported = Rigid3::new(ahead, Vector3::new(0.0, 0.0, 0.5));
    let correction = MountCorrection { pitch_down_deg: 10.0, roll_clockwise_deg: 0.0, height_m: 0.1 };
    let real = correction.apply(&reported);
    assert!((real.translation().z - 0.6).abs() < 1e-12);
    assert!((real.rotate(&Vector3::z()).z + 10.0_f64.to_radians().sin()).abs() < 1e-12);
    let rolled = MountCorrection { roll_clockwise_deg: 10.0, ..MountCorrection::default() }.apply(&reported);
    assert!(rolled.rotate(&Vector3::x()).z < -0.1, "the right side is lower");
}

#[test]
fn an_empty_drive_is_refused() {
    let refused = solve_odometry(&DriveRecord::default()).unwrap_err();
    assert_eq!(refused, RobotCalibrationError::NoOdometry);
}
