//! The ground below the way of a camera: who was carried or driven along a way had nothing but the ground below.

use nalgebra::{Point3, Vector3};
use visloc_core::median;
use visloc_slam::map::{Keyframe, Map};

/// Distance to the side of the way, in heights of the camera, up to which there is nothing but the ground.
const BESIDE: f64 = 1.0;
/// Heights whose logarithms differ by so much are about the same: about what depths are off by.
const ALIKE: f64 = 0.05;
/// Height below the ground, share of the height of the camera, at which there is nothing but mistakes.
const BELOW: f64 = 0.2;
/// Such mistakes, as a share of the points of the ground.
const MOST_BELOW: f64 = 0.1;
/// Fewest points of the ground, and fewest pieces of the way, from keyframe to keyframe, that have some.
const LEAST_POINTS: usize = 20;
const LEAST_PIECES: usize = 5;
/// Fewest keyframes that saw a point that is used.
const LEAST_SEEN: usize = 3;
/// A piece that is longer than so many usual ones was not gone: the camera was lost there.
const JUMP: f64 = 10.0;
/// Least part of the image's upward direction across the way: a camera that goes up and down tells no height.
const LEAST_UPRIGHT: f64 = 0.5;
/// The standard deviation as a multiple of the median deviation, and that of a median as a multiple of that of a mean.
const SIGMA_OF_MEDIAN: (f64, f64) = (1.48, 1.25);

/// What a map says of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Median height of the camera above it, map units.
    pub height: f64,
    /// Standard deviation of that, share of the height: the spread of the points, with those below a piece of the way counted as one.
    pub relative_sigma: f64,
    /// Points of the ground.
    pub num_points: usize,
    /// Pieces of the way, from keyframe to keyframe, above them.
    pub num_pieces: usize,
}

/// A place of the camera, and which way is up in its image.
type Place = (Point3<f64>, Vector3<f64>);

/// Finds the ground below the way of the camera in the map that is active. `None` if it shows too little of it.
pub fn find_ground(map: &Map) -> Option<Ground> {
    // The axes of the images point down.
    let up = |keyframe: &Keyframe| -keyframe.camera_from_world().rotation().row(1).transpose();
    let way: Vec<Place> =
        map.keyframes().map(|(_, keyframe)| (*keyframe.center_in_world(), up(keyframe))).collect();
    let landmarks = map.landmarks().filter(|(_, l)| l.is_converged() && l.observations.len() >= LEAST_SEEN);
    let points: Vec<Point3<f64>> = landmarks.map(|(_, l)| l.point_in_world).collect();
    ground_below(&way, &points)
}

/// The same from the places of the camera and points.
fn ground_below(way: &[Place], points: &[Point3<f64>]) -> Option<Ground> {
    let longest = JUMP * median(way.windows(2).map(|piece| (piece[1].0 - piece[0].0).norm()))?;
    // Logarithm of the height, and the piece of the way.
    let below: Vec<(f64, usize)> = points
        .iter()
        .filter_map(|point| {
            let pieces = way.windows(2).enumerate();
            let seen = pieces.filter_map(|(i, piece)| Some((below_piece(piece, longest, point)?, i)));
            seen.min_by(|a, b| a.0.1.total_cmp(&b.0.1))
        })
        .filter(|((height, beside), _)| *height > 0.0 && *beside < BESIDE * height)
        .map(|((height, _), piece)| (height.ln(), piece))
        .collect();
    let mut middle = most_frequent(&below)?;
    let near = |middle: f64| below.iter().filter(move |point| (point.0 - middle).abs() < 2.0 * ALIKE);
    for _ in 0..5 {
        middle = median(near(middle).map(|point| point.0))?;
    }
    let num_points = near(middle).count();
    let mut pieces: Vec<usize> = near(middle).map(|point| point.1).collect();
    pieces.sort_unstable();
    pieces.dedup();
    let spread = median(near(middle).map(|point| (point.0 - middle).abs()))?;
    let num_below = below.iter().filter(|point| point.0 > middle + BELOW.ln_1p()).count();
    let is_sure = num_points >= LEAST_POINTS
        && pieces.len() >= LEAST_PIECES
        && num_below as f64 <= MOST_BELOW * num_points as f64;
    let relative_sigma = SIGMA_OF_MEDIAN.0 * SIGMA_OF_MEDIAN.1 * spread / (pieces.len() as f64).sqrt();
    is_sure.then_some(Ground { height: middle.exp(), relative_sigma, num_points, num_pieces: pieces.len() })
}

/// How far below a piece of the way and how far beside it a point lies. Upright is across the way, which runs along the ground.
fn below_piece(piece: &[Place], longest: f64, point: &Point3<f64>) -> Option<(f64, f64)> {
    let ((from, up_from), (to, up_to)) = (piece[0], piece[1]);
    let length = (to - from).norm();
    let along = (to - from).try_normalize(1e-12).filter(|_| length <= longest)?;
    let up = up_from + up_to;
    let up = (up - along * along.dot(&up)) / up.norm();
    let up = up.try_normalize(LEAST_UPRIGHT)?;
    let nearest = from + along * along.dot(&(point - from)).clamp(0.0, length);
    let from_way = point - nearest;
    let height = -up.dot(&from_way);
    Some((height, (from_way + up * height).norm()))
}

/// Where most values lie: the peak of their density.
fn most_frequent(values: &[(f64, usize)]) -> Option<f64> {
    let density = |middle: f64| -> f64 {
        values.iter().map(|(value, _)| (-0.5 * ((value - middle) / ALIKE).powi(2)).exp()).sum()
    };
    let dense = values.iter().map(|(value, _)| (*value, density(*value)));
    dense.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(value, _)| value)
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use visloc_core::{RngTree, gaussian};

    use super::*;

    /// A way with a turn, 1.5 above a ground that rises by 4 %, with walls and tables beside and depths that are off by 4 %.
    fn street(seed: u64, num_on_ground: usize) -> (Vec<Place>, Vec<Point3<f64>>) {
        let mut rng = RngTree::new(seed).stream("street", 0);
        let place = |s: f64| {
            let (x, y) = if s < 30.0 { (s, 0.0) } else { (30.0, s - 30.0) };
            Point3::new(x, y, 0.04 * s)
        };
        // The camera looks down or up a little, and rolls.
        let way = (0..30).map(|i| {
            let tilt = Vector3::new(0.2, 0.03 * f64::from(i % 3), 1.0);
            (place(2.0 * f64::from(i)) + Vector3::new(0.0, 0.0, 1.5), tilt.normalize())
        });
        let way: Vec<Place> = way.collect();
        let mut points = Vec::new();
        for i in 0..num_on_ground + 600 {
            let s = rng.random_range(2.0..56.0);
            let beside = rng.random_range(-1.4..1.4);
            let at = place(s);
            let across =
                if s < 30.0 { Vector3::new(0.0, beside, 0.0) } else { Vector3::new(beside, 0.0, 0.0) };
            let error = 1.0 + gaussian(&mut rng, 0.04);
            let (across, drop) = if i < num_on_ground {
                (across, 1.5 * error)
            } else {
                // Walls and parked cars.
                (across * rng.random_range(2.0..6.0), rng.random_range(-3.0..1.4))
            };
            points.push(at + across + Vector3::new(0.0, 0.0, 1.5 - drop));
        }
        (way, points)
    }

    #[test]
    fn the_height_over_a_street_is_found_and_its_error_covered() {
        let mut num_covered = 0;
        for seed in 1..=20 {
            let (way, points) = street(seed, 120);
            let ground = ground_below(&way, &points).unwrap();
            let error = ground.height / 1.5 - 1.0;
            assert!(error.abs() < 0.02 && ground.relative_sigma < 0.02, "seed {seed}: {ground:?}");
            num_covered += usize::from(error.abs() < 2.0 * ground.relative_sigma);
        }
        assert!(num_covered >= 19, "{num_covered}");
    }

    #[test]
    fn a_way_above_no_ground_tells_nothing() {
        for seed in 1..=5 {
            let (way, points) = street(seed, 0);
            assert_eq!(ground_below(&way, &points), None, "seed {seed}");
            let (way, _) = street(seed, 0);
            assert_eq!(ground_below(&way, &[]), None);
            assert_eq!(ground_below(&way[..1], &points), None);
        }
    }
}
