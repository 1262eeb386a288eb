#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss
)]

use nalgebra::{Point2, Rotation3, Vector3};
use visloc_core::{
    Frame, RgbImage, Rng, RngTree, Timestamp, gaussian,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot},
};

use super::GroundOdometer;

const SIZE_PX: (u32, u32) = (160, 120);
const HEIGHT_M: f64 = 0.5;
const RATE: f64 = 30.0;

/// The camera looks down by `pitch_rad` and to the left by `pan_rad`.
fn robot_from_camera(pan_rad: f64, pitch_rad: f64) -> Rigid3<Robot, CameraFrame> {
    let ahead = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0,
    ));
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), pan_rad)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), pitch_rad);
    Rigid3::new(turned * ahead, Vector3::new(0.0, 0.0, HEIGHT_M))
}

/// A carpet, -1 to 1: small and large spots.
fn carpet(at: &Point2<f64>) -> f64 {
    0.5 * (cells(at, 0.05) + cells(at, 0.2))
}

/// A random value in each cell of so many meters, -1 to 1, and what lies between.
fn cells(at: &Point2<f64>, size_m: f64) -> f64 {
    let (x, y) = (at.x / size_m, at.y / size_m);
    let (column, row) = (x.floor(), y.floor());
    let tuft = |dx: f64, dy: f64| {
        let cell = ((column + dx) as i64 as u64).wrapping_mul(0x9e37_79b9) ^ (row + dy) as i64 as u64;
        let bits = RngTree::new(1).stream_seed("carpet", cell) >> 40;
        bits as f64 / f64::from(1_u32 << 23) - 1.0
    };
    let (fx, fy) = (x - column, y - row);
    let upper = tuft(0.0, 0.0) * (1.0 - fx) + tuft(1.0, 0.0) * fx;
    let lower = tuft(0.0, 1.0) * (1.0 - fx) + tuft(1.0, 1.0) * fx;
    upper * (1.0 - fy) + lower * fy
}

/// What the camera of a robot sees, with noise; `texture` is the contrast of the carpet, gray levels. Above the horizon there is a wall.
fn image(
    camera: &Camera,
    world_from_robot: &PlanarPose,
    pose: &Rigid3<Robot, CameraFrame>,
    (brightness, texture): (f64, f64),
    rng: &mut Rng,
) -> RgbImage {
    let mut image = RgbImage::new(SIZE_PX.0, SIZE_PX.1);
    for y in 0..SIZE_PX.1 {
        for x in 0..SIZE_PX.0 {
            let ray = pose.rotate(&camera.bearing(&Point2::new(f64::from(x), f64::from(y))));
            let gray = if ray.z < -1e-3 {
                let at = pose.translation() - ray * (HEIGHT_M / ray.z);
                brightness + texture * carpet(&world_from_robot.transform(&at.xy().into()))
            } else {
                200.0
            };
            image.set(x, y, [(gray + gaussian(rng, 2.0)).round().clamp(0.0, 255.0) as u8; 3]);
        }
    }
    image
}

/// Drives with a panning camera whose pose is reported with an error of 0.2 degrees, and returns where the odometer says that the robot
/// is and where it is, after each image.
fn drive(num_images: u32, texture: f64, seed: u64) -> Vec<(Option<PlanarPose>, PlanarPose)> {
    let camera = Camera::pinhole(SIZE_PX, (180.0, 180.0), (79.5, 59.5)).unwrap();
    let (mut odometer, mut rng) = (GroundOdometer::new(), RngTree::new(seed).stream("images", 0));
    let (mut robot, mut out) = (PlanarPose::default(), Vec::new());
    for i in 0..num_images {
        let secs = f64::from(i) / RATE;
        let pan_rad = 0.4 * (2.0 * secs).sin();
        let light = (110.0 + 20.0 * (3.0 * secs).sin(), texture);
        let seen = image(&camera, &robot, &robot_from_camera(pan_rad, 0.45), light, &mut rng);
        let reported = robot_from_camera(pan_rad, 0.45 + gaussian(&mut rng, 0.0035));
        let at = Timestamp::from_secs(secs);
        out.push((odometer.step(&Frame::new(at, seen, camera, reported)), robot));
        robot = robot.compose(&PlanarPose::new(0.3 / RATE, 0.05 / RATE, 0.5 / RATE));
    }
    out
}

#[test]
fn a_robot_is_followed_over_a_carpet_in_changing_light() {
    for seed in 1..4 {
        let way = drive(60, 30.0, seed);
        let (found, real) = way.last().unwrap();
        let found = found.unwrap();
        assert!(found.distance_m(real) < 0.05, "{found:?} {real:?}");
        assert!(found.heading_difference_rad(real) < 0.05, "{found:?} {real:?}");
    }
}

#[test]
fn on_a_ground_without_texture_the_motion_is_unknown() {
    let way = drive(40, 0.0, 1);
    assert!(way[..10].iter().all(|(found, _)| found.is_some()), "it may go on as before for a moment");
    assert!(way[20..].iter().all(|(found, _)| found.is_none()));
}

#[test]
fn after_a_gap_the_motion_counts_from_there() {
    let camera = Camera::pinhole(SIZE_PX, (180.0, 180.0), (79.5, 59.5)).unwrap();
    let (mut odometer, mut rng) = (GroundOdometer::new(), RngTree::new(5).stream("images", 0));
    let pose = robot_from_camera(0.0, 0.45);
    let mut step = |secs: f64, x_m: f64| {
        let seen = image(&camera, &PlanarPose::new(x_m, 0.0, 0.0), &pose, (110.0, 30.0), &mut rng);
        odometer.step(&Frame::new(Timestamp::from_secs(secs), seen, camera, pose)).unwrap()
    };
    assert_eq!(step(0.0, 0.0), PlanarPose::default());
    let before = step(0.033, 0.01);
    assert!((before.x_m - 0.01).abs() < 0.003, "{before:?}");
    assert_eq!(step(5.0, 2.0), before);
    assert!((step(5.033, 2.01).x_m - before.x_m - 0.01).abs() < 0.003);
}
