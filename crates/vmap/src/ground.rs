//! The ground below the cameras of a map.

use nalgebra::{Matrix3, Point3, Vector3};
use rand::RngExt;
use visloc_core::{Rng, RngTree};
use visloc_slam::map::{Keyframe, Map};

/// Planes that are tried below each keyframe.
const SAMPLES: usize = 300;
/// Distance to which the ground is taken for a plane, in heights of the camera.
const REACH: f64 = 8.0;
/// Distance of a point of the ground from its plane, share of the height of the camera: about what depths are off by.
const THICKNESS: f64 = 0.04;
/// Depth below the ground, share of the height of the camera, at which there is nothing but mistakes.
const BELOW: f64 = 0.15;
/// Share of the points in reach that may be such mistakes.
const MOST_BELOW: f64 = 0.1;
/// Cosine of the angle up to which the ground is inclined to a camera that is held upright: 30 degrees.
const LEAST_UPRIGHT: f64 = 0.866;
/// Fewest points of the ground below a keyframe, and fewest keyframes above ground.
const LEAST_POINTS: usize = 15;
const LEAST_KEYFRAMES: usize = 5;
/// Share of the height by which keyframes may differ from it: more, and the camera was not carried at one height, or it is no ground.
const MOST_SPREAD: f64 = 0.2;
/// Fewest keyframes that saw a point that is used.
const LEAST_SEEN: usize = 3;

/// What keyframes say of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Median height of the keyframes above it, map units.
    pub height: f64,
    /// Usual difference of a keyframe from it, map units: 1.48 times the median.
    pub spread: f64,
    /// Keyframes below which it was found.
    pub num_keyframes: usize,
}

/// A plane: points with `normal * x = offset`.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vector3<f64>,
    offset: f64,
}

impl Plane {
    fn above(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }

    /// Whether the ground below a camera is taken for this plane as far as to a point.
    fn reaches(&self, center: &Point3<f64>, height: f64, point: &Point3<f64>) -> bool {
        (point - center).norm_squared() < (REACH * height).powi(2)
    }
}

/// Finds the ground below the keyframes of the map that is active: below each the plane with most points among those that are about level for
/// an upright camera and have hardly anything below. A road may rise and fall. `None` if it is found below too few keyframes.
#[must_use]
pub fn find_ground(map: &Map) -> Option<Ground> {
    let landmarks = map.landmarks().filter(|(_, l)| l.is_converged() && l.observations.len() >= LEAST_SEEN);
    let points: Vec<Point3<f64>> = landmarks.map(|(_, l)| l.point_in_world).collect();
    let mut rng = RngTree::new(0).stream("ground", 0);
    let below = |(_, keyframe): (_, &Keyframe)| height_of(keyframe, map, &points, &mut rng);
    let heights: Vec<f64> = map.keyframes().filter_map(below).collect();
    let height = median(heights.clone())?;
    let spread = 1.48 * median(heights.iter().map(|other| (other - height).abs()).collect())?;
    let is_sure = heights.len() >= LEAST_KEYFRAMES && spread < MOST_SPREAD * height;
    is_sure.then_some(Ground { height, spread, num_keyframes: heights.len() })
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Height of a keyframe above the ground.
fn height_of(keyframe: &Keyframe, map: &Map, points: &[Point3<f64>], rng: &mut Rng) -> Option<f64> {
    let center = keyframe.center_in_world();
    // The axes of the images point down.
    let up = -keyframe.camera_from_world().rotation().row(1).transpose();
    let seen: Vec<Point3<f64>> = keyframe
        .landmarks
        .iter()
        .map(|id| map.landmark(*id))
        .filter(|l| l.is_converged() && l.observations.len() >= LEAST_SEEN)
        .map(|l| l.point_in_world)
        .collect();
    let mut best: Option<(usize, Plane)> = None;
    for _ in 0..SAMPLES {
        let Some(plane) = sample(&seen, &up, rng) else { continue };
        let num = num_on(&plane, center, &seen);
        if best.is_none_or(|(most, _)| num > most) && is_lowest(&plane, center, points) {
            best = Some((num, plane));
        }
    }
    let (_, mut plane) = best?;
    for _ in 0..3 {
        plane = refined(&plane, center, points, &up)?;
    }
    let is_found = num_on(&plane, center, points) >= LEAST_POINTS && is_lowest(&plane, center, points);
    is_found.then(|| plane.above(center)).filter(|height| *height > 0.0)
}

fn sample(points: &[Point3<f64>], up: &Vector3<f64>, rng: &mut Rng) -> Option<Plane> {
    if points.len() < LEAST_POINTS {
        return None;
    }
    let [a, b, c] = std::array::from_fn(|_| points[rng.random_range(0..points.len())]);
    let normal = (b - a).cross(&(c - a)).try_normalize(1e-12)?;
    oriented(normal, up).map(|normal| Plane { normal, offset: normal.dot(&a.coords) })
}

fn oriented(normal: Vector3<f64>, up: &Vector3<f64>) -> Option<Vector3<f64>> {
    let normal = if normal.dot(up) < 0.0 { -normal } else { normal };
    (normal.dot(up) > LEAST_UPRIGHT).then_some(normal)
}

fn num_on(plane: &Plane, center: &Point3<f64>, points: &[Point3<f64>]) -> usize {
    on(plane, center, points).count()
}

/// The points in reach that lie on a plane below a camera.
fn on<'a>(
    plane: &'a Plane,
    center: &'a Point3<f64>,
    points: &'a [Point3<f64>],
) -> impl Iterator<Item = &'a Point3<f64>> {
    let height = plane.above(center).max(0.0);
    points.iter().filter(move |point| {
        plane.above(point).abs() < THICKNESS * height && plane.reaches(center, height, point)
    })
}

/// Whether there is hardly anything below a plane.
fn is_lowest(plane: &Plane, center: &Point3<f64>, points: &[Point3<f64>]) -> bool {
    let height = plane.above(center);
    let (mut num, mut num_below) = (0_usize, 0_usize);
    for point in points.iter().filter(|point| plane.reaches(center, height, point)) {
        num += 1;
        num_below += usize::from(plane.above(point) < -BELOW * height);
    }
    height > 0.0 && num_below as f64 <= MOST_BELOW * num as f64
}

/// The plane through all points that lie on it.
fn refined(plane: &Plane, center: &Point3<f64>, points: &[Point3<f64>], up: &Vector3<f64>) -> Option<Plane> {
    let on: Vec<&Point3<f64>> = on(plane, center, points).collect();
    let mean = on.iter().map(|point| point.coords).sum::<Vector3<f64>>() / on.len().max(1) as f64;
    let spread: Matrix3<f64> =
        on.iter().map(|point| (point.coords - mean) * (point.coords - mean).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    let normal = oriented(normal.try_normalize(1e-12)?, up)?;
    Some(Plane { normal, offset: normal.dot(&mean) })
}
