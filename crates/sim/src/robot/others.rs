//! Other robots that walk around.

use std::f64::consts::TAU;

use nalgebra::Point2;
use rand::RngExt as _;
use visloc_core::{Rng, geom::PlanarPose};

use super::floor::Floor;

/// Time between the moments at which ways are compared.
const CHECK_EVERY_SECS: f64 = 0.25;
/// Robots keep at least this far apart, center to center, meters.
const CLEARANCE_M: f64 = 0.6;

/// A walk around an ellipse.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Orbit {
    center: Point2<f64>,
    radii_m: (f64, f64),
    rate_rad_per_s: f64,
    start_rad: f64,
}

impl Orbit {
    fn random(floor: &Floor, rng: &mut Rng) -> Self {
        let radii_m = (rng.random_range(0.15..0.9_f64), rng.random_range(0.15..0.9_f64));
        let speed_m_per_s = rng.random_range(0.05..0.14);
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        Self {
            center: floor.random_point(rng),
            radii_m,
            rate_rad_per_s: sign * speed_m_per_s / radii_m.0.max(radii_m.1),
            start_rad: rng.random_range(0.0..TAU),
        }
    }

    /// Where the robot is after a time since the start; it looks where it goes.
    pub(crate) fn pose(&self, secs: f64) -> PlanarPose {
        let (sin, cos) = (self.start_rad + self.rate_rad_per_s * secs).sin_cos();
        let (a, b) = self.radii_m;
        let yaw_rad = (b * cos * self.rate_rad_per_s).atan2(-a * sin * self.rate_rad_per_s);
        PlanarPose::new(self.center.x + a * cos, self.center.y + b * sin, yaw_rad)
    }

    fn track(&self, num_checks: usize) -> Vec<Point2<f64>> {
        (0..num_checks).map(|i| self.pose(i as f64 * CHECK_EVERY_SECS).position()).collect()
    }
}

/// Orbits for `count` robots that keep clear of obstacles, of each other and of `own_position` (by time since the start)
/// at all times. Fewer than `count` if the floor is too crowded.
pub(crate) fn find_orbits(
    count: usize,
    floor: &Floor,
    duration_secs: f64,
    own_position: impl Fn(f64) -> Point2<f64>,
    rng: &mut Rng,
) -> Vec<Orbit> {
    const TRIES: usize = 6000;
    let num_checks = (duration_secs / CHECK_EVERY_SECS).ceil() as usize + 1;
    let own = (0..num_checks).map(|i| own_position(i as f64 * CHECK_EVERY_SECS)).collect();
    let mut tracks: Vec<Vec<Point2<f64>>> = vec![own];
    let mut orbits = Vec::new();
    for _ in 0..TRIES {
        if orbits.len() == count {
            break;
        }
        let orbit = Orbit::random(floor, rng);
        let track = orbit.track(num_checks);
        let is_clear = track.iter().enumerate().all(|(i, point)| {
            floor.is_free(point, 0.0) && tracks.iter().all(|other| (other[i] - point).norm() > CLEARANCE_M)
        });
        if is_clear {
            orbits.push(orbit);
            tracks.push(track);
        }
    }
    orbits
}
