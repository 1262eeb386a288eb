//! The ground below the cameras of a map.

use nalgebra::{Matrix3, Point3, Vector3};
use rand::RngExt;
use visloc_core::{Rng, RngTree};
use visloc_slam::map::Map;

/// Planes that are tried.
const SAMPLES: usize = 2_000;
/// Distance of a point of the ground from its plane, share of the height of the cameras: about what depths are off by.
const THICKNESS: f64 = 0.03;
/// Depth below the ground, share of the height of the cameras, at which there is nothing but mistakes.
const BELOW: f64 = 0.15;
/// Share of all points that may be such mistakes.
const MOST_BELOW: f64 = 0.05;
/// Cosine of the angle up to which cameras may be tilted on average: 30 degrees.
const LEAST_UPRIGHT: f64 = 0.866;
/// Fewest points of the ground.
const LEAST_POINTS: usize = 30;
/// Fewest keyframes that saw a point that is used.
const LEAST_SEEN: usize = 3;

/// The ground of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Upwards.
    pub up: Vector3<f64>,
    /// Median height of the keyframes above it, map units.
    pub height: f64,
    /// Usual difference of a keyframe from it, map units: 1.48 times the median.
    pub spread: f64,
    /// Points that lie on it.
    pub num_points: usize,
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
}

/// Finds the ground of the map that is active: the plane with most points among those that are about level for upright cameras, below
/// them, and have hardly anything below. `None` if there is none.
#[must_use]
pub fn find_ground(map: &Map) -> Option<Ground> {
    let centers: Vec<Point3<f64>> = map.keyframes().map(|(_, k)| *k.center_in_world()).collect();
    // The axes of the images point down.
    let up = -map
        .keyframes()
        .map(|(_, k)| k.camera_from_world().rotation().row(1).transpose())
        .sum::<Vector3<f64>>();
    let up = up.try_normalize(1e-9)?;
    let landmarks = map.landmarks().filter(|(_, l)| l.is_converged() && l.observations.len() >= LEAST_SEEN);
    let points: Vec<Point3<f64>> = landmarks.map(|(_, l)| l.point_in_world).collect();
    let mut rng = RngTree::new(0).stream("ground", 0);
    let mut best: Option<(usize, Plane)> = None;
    for _ in 0..SAMPLES {
        let Some(plane) = sample(&points, &up, &mut rng) else { continue };
        let Some(num) = score(&plane, &points, &centers) else { continue };
        if best.is_none_or(|(most, _)| num > most) {
            best = Some((num, plane));
        }
    }
    let (_, mut plane) = best?;
    for _ in 0..5 {
        plane = refined(&plane, &points, &centers, &up)?;
    }
    let num_points = score(&plane, &points, &centers).filter(|num| *num >= LEAST_POINTS)?;
    let (height, spread) = heights(&plane, &centers)?;
    Some(Ground { up: plane.normal, height, spread, num_points })
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

/// Median height of the cameras and its spread; `None` if it is not above the plane.
fn heights(plane: &Plane, centers: &[Point3<f64>]) -> Option<(f64, f64)> {
    let height = median(centers.iter().map(|center| plane.above(center)).collect())?;
    let spread = median(centers.iter().map(|center| (plane.above(center) - height).abs()).collect())?;
    (height > 0.0).then_some((height, 1.48 * spread))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// How many points lie on a plane; `None` if it is not below the cameras and above nothing.
fn score(plane: &Plane, points: &[Point3<f64>], centers: &[Point3<f64>]) -> Option<usize> {
    let (height, _) = heights(plane, centers)?;
    let num_below = points.iter().filter(|point| plane.above(point) < -BELOW * height).count();
    let is_lowest = num_below as f64 <= MOST_BELOW * points.len() as f64;
    is_lowest.then(|| points.iter().filter(|point| plane.above(point).abs() < THICKNESS * height).count())
}

/// The plane through all points that lie on it.
fn refined(
    plane: &Plane,
    points: &[Point3<f64>],
    centers: &[Point3<f64>],
    up: &Vector3<f64>,
) -> Option<Plane> {
    let (height, _) = heights(plane, centers)?;
    let on: Vec<&Point3<f64>> =
        points.iter().filter(|point| plane.above(point).abs() < THICKNESS * height).collect();
    let mean = on.iter().map(|point| point.coords).sum::<Vector3<f64>>() / on.len().max(1) as f64;
    let spread: Matrix3<f64> =
        on.iter().map(|point| (point.coords - mean) * (point.coords - mean).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    let normal = oriented(normal.try_normalize(1e-12)?, up)?;
    Some(Plane { normal, offset: normal.dot(&mean) })
}
