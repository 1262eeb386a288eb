//! Poses as somebody who calibrates with care would hold the board.

use std::f64::consts::PI;

use nalgebra::{Point2, Point3, Rotation3, Vector3};
use rand::RngExt;
use visloc_core::{
    Rng,
    geom::{Camera, Rigid3},
};

use crate::{Board, CameraFromBoard};

/// Tries until the board is in view.
const MAX_TRIES: usize = 2000;
/// Corners stay so far inside of the border, pixels.
const BORDER_PX: f64 = 12.0;
/// The board's longer side as a share of the image's shorter side.
const SHARES: (f64, f64) = (0.45, 1.05);
const MAX_TILT_RAD: f64 = 0.75;

/// A pose with all corners in view: anywhere in the image, tilted up to 43 degrees, from near to far. `None` if the camera
/// cannot see the board.
pub fn random_pose(board: &Board, camera: &Camera, rng: &mut Rng) -> Option<CameraFromBoard> {
    let [low, high] = board.bounds_m();
    let longer_m = (high - low).max();
    let (width, height) = (f64::from(camera.size_px().0), f64::from(camera.size_px().1));
    let candidates = (0..MAX_TRIES).map(|_| {
        let mut draw = |from: f64, to: f64| rng.random_range(from..to);
        let px = Point2::new(draw(0.1, 0.9) * width, draw(0.1, 0.9) * height);
        let distance_m = camera.focal_px().0 * longer_m / (draw(SHARES.0, SHARES.1) * width.min(height));
        let (tilt, towards, spin) = (draw(0.0, MAX_TILT_RAD), draw(-PI, PI), draw(-0.5, 0.5));
        let ray = camera.bearing(&px).normalize();
        // The board looks along the ray, then it is tilted and spun.
        let facing = Rotation3::rotation_between(&Vector3::z(), &ray).unwrap_or_else(Rotation3::identity);
        let tilted = Rotation3::from_scaled_axis(Vector3::new(towards.cos(), towards.sin(), 0.0) * tilt);
        let rotation = facing * tilted * Rotation3::from_scaled_axis(Vector3::z() * spin);
        let center = ray * distance_m;
        Rigid3::new(rotation, center - rotation * board.center_in_board().coords)
    });
    let is_in_view = |pose: &CameraFromBoard| {
        (0..board.num_corners()).all(|id| sees(camera, &pose.transform(&board.corner_in_board(id))))
    };
    candidates.into_iter().find(is_in_view)
}

fn sees(camera: &Camera, point_in_camera: &Point3<f64>) -> bool {
    let (width, height) = (f64::from(camera.size_px().0), f64::from(camera.size_px().1));
    camera.project(point_in_camera).is_ok_and(|px| {
        px.x > BORDER_PX && px.y > BORDER_PX && px.x < width - BORDER_PX && px.y < height - BORDER_PX
    })
}
