//! The center circle. Every piece of a line votes for the two centers a radius away from it on either side; the best of
//! the places with most votes is fitted and compared with the image.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point2, Vector2};

use super::{
    chains::Chains,
    crossings::Crossing,
    segments::Segment,
    view::{GroundView, Seen},
};
use crate::vision::CenterCircle;

/// The votes cover this far around the robot, meters, in cells of this size.
const REACH_M: f64 = 6.0;
const CELL_M: f64 = 0.2;
const CELLS: usize = 60;
/// Fewest votes, and how many places are tried.
const MIN_VOTES: u16 = 5;
const MAX_TRIES: usize = 3;
/// A crossing belongs to the circle if it is this near, meters and pixels.
const NEAR_M: f64 = 0.04;
const NEAR_PX: f64 = 2.5;
/// Fewest crossings that belong to a circle.
const MIN_CROSSINGS: usize = 6;
/// Steps of the fit.
const NUM_STEPS: usize = 5;
/// Points of the circle that are looked at in the image.
const NUM_SAMPLES: u32 = 36;
/// Fewest of them in the image, and share of those that must be white, and carpet on both sides.
const MIN_SEEN: u32 = 5;
const MIN_WHITE: f64 = 0.7;
const MIN_CARPET: f64 = 0.6;
/// A circle of which fewer points are in the image must agree this well.
const MANY_SEEN: u32 = 9;
const MIN_WHITE_OF_FEW: f64 = 0.9;
const MIN_CARPET_OF_FEW: f64 = 0.75;
/// How near the halfway line passes to the center, meters and pixels.
const HALFWAY_OFF_M: f64 = 0.08;
const HALFWAY_OFF_PX: f64 = 3.0;

#[derive(Debug, Default)]
pub(super) struct CircleFinder {
    votes: Vec<u16>,
}

impl CircleFinder {
    /// Finds the circle; takes the pieces of it out of the segments.
    pub fn find(
        &mut self,
        crossings: &[Crossing],
        chains: &Chains,
        view: &GroundView,
        (radius_m, line_width_m): (f64, f64),
        segments: &mut Vec<Segment>,
    ) -> Option<CenterCircle> {
        self.vote(crossings, chains, radius_m);
        for _ in 0..MAX_TRIES {
            let Some(start) = self.take_best() else { break };
            let Some(center) = fit(start, crossings, view, radius_m) else { continue };
            let Some(visible_share) = share_in_image(&center, view, radius_m, line_width_m, crossings) else {
                continue;
            };
            segments.retain(|segment| !is_arc(segment, &center, view, radius_m));
            let halfway_rad = halfway(segments, &center, view);
            return Some(CenterCircle { center_in_robot: center, visible_share, halfway_rad });
        }
        None
    }

    fn vote(&mut self, crossings: &[Crossing], chains: &Chains, radius_m: f64) {
        self.votes.clear();
        self.votes.resize(CELLS * CELLS, 0);
        for (i, crossing) in crossings.iter().enumerate() {
            let Some(before) = chains.before[i] else { continue };
            let first = chains.before[before].unwrap_or(before);
            let along = crossing.ground - crossings[first].ground;
            let length = along.norm();
            if length < 0.02 {
                continue;
            }
            // The chord between two points of a circle is a little nearer to the center than its ends.
            let height_m = (radius_m * radius_m - length * length / 4.0).max(0.0).sqrt();
            let across = Vector2::new(-along.y, along.x) * (height_m / length);
            let middle = nalgebra::center(&crossing.ground, &crossings[first].ground);
            for center in [middle + across, middle - across] {
                if let Some(cell) = cell(&center) {
                    self.votes[cell] += 1;
                }
            }
        }
    }

    /// The middle of the four cells with most votes together, which are then emptied.
    fn take_best(&mut self) -> Option<Point2<f64>> {
        let (mut best, mut count) = (0, 0);
        let rows = self.votes.as_chunks::<CELLS>().0;
        for (row, both) in rows.windows(2).enumerate() {
            let columns: [u16; CELLS] = std::array::from_fn(|column| both[0][column] + both[1][column]);
            let sums: [u16; CELLS - 1] = std::array::from_fn(|column| columns[column] + columns[column + 1]);
            let most = sums.iter().fold(0, |most, sum| most.max(*sum));
            if most > count {
                let column = sums.iter().position(|sum| *sum == most).unwrap_or(0);
                (best, count) = (row * CELLS + column, most);
            }
        }
        if count < MIN_VOTES {
            return None;
        }
        for i in [best, best + 1, best + CELLS, best + CELLS + 1] {
            self.votes[i] = 0;
        }
        let at = |i: usize| (i as f64 + 1.0) * CELL_M - REACH_M;
        Some(Point2::new(at(best % CELLS), at(best / CELLS)))
    }
}

fn cell(point: &Point2<f64>) -> Option<usize> {
    let (x, y) = ((point.x + REACH_M) / CELL_M, (point.y + REACH_M) / CELL_M);
    let is_inside = x >= 0.0 && y >= 0.0 && x < CELLS as f64 && y < CELLS as f64;
    is_inside.then_some(y as usize * CELLS + x as usize)
}

/// Length on the ground at which a crossing counts as near to a circle around `center`.
fn near_m(crossing: &Point2<f64>, center: &Point2<f64>, view: &GroundView) -> (Vector2<f64>, f64) {
    let from_center = crossing - center;
    let outward = from_center / from_center.norm().max(1e-6);
    (outward, NEAR_M + NEAR_PX * view.scale * view.meters_per_px(crossing, &outward))
}

/// Moves the center to where the crossings near the circle lie on it, each weighed by its precision.
fn fit(start: Point2<f64>, crossings: &[Crossing], view: &GroundView, radius_m: f64) -> Option<Point2<f64>> {
    let mut center = start;
    for step in 0..NUM_STEPS {
        let mut information = nalgebra::Matrix2::identity() * 1e-3;
        let mut gradient = Vector2::zeros();
        let mut count = 0;
        for crossing in crossings {
            let off = (crossing.ground - center).norm() - radius_m;
            let (outward, near) = near_m(&crossing.ground, &center, view);
            // The first steps start up to a cell away.
            let gate = if step < 2 { near + CELL_M } else { near };
            if off.abs() < gate {
                let weight = 1.0 / (near * near);
                information += outward * outward.transpose() * weight;
                gradient += outward * (off * weight);
                count += 1;
            }
        }
        if count < MIN_CROSSINGS {
            return None;
        }
        center += information.try_inverse()? * gradient;
    }
    ((center - start).norm() < 4.0 * CELL_M).then_some(center)
}

/// Share of the circle that is in the image and white with carpet on both sides; `None` if that is too little for a circle.
fn share_in_image(
    center: &Point2<f64>,
    view: &GroundView,
    radius_m: f64,
    line_width_m: f64,
    crossings: &[Crossing],
) -> Option<f64> {
    let white = crossings.first()?.white;
    let (mut seen, mut num_white, mut num_carpet) = (0, 0, 0);
    for i in 0..NUM_SAMPLES {
        let (sin, cos) = (f64::from(i) / f64::from(NUM_SAMPLES) * TAU).sin_cos();
        let outward = Vector2::new(cos, sin);
        let at = center + outward * radius_m;
        let beside = line_width_m + 2.0 * view.scale * view.meters_per_px(&at, &outward);
        // Farther away the two sides of the line cannot be told apart.
        if beside > radius_m / 2.0 {
            continue;
        }
        let Some(across) = across_px(&at, &outward, view) else { continue };
        match view.at_ground(&at, &across, white) {
            Seen::Nothing => continue,
            Seen::White => num_white += 1,
            _ => {}
        }
        seen += 1;
        let is_carpet =
            |off: f64| view.px(&(at + outward * off)).map(|px| view.at_px(&px, white)) == Some(Seen::Carpet);
        num_carpet += u32::from(is_carpet(beside)) + u32::from(is_carpet(-beside));
    }
    let (min_white, min_carpet) =
        if seen < MANY_SEEN { (MIN_WHITE_OF_FEW, MIN_CARPET_OF_FEW) } else { (MIN_WHITE, MIN_CARPET) };
    let is_circle = seen >= MIN_SEEN
        && f64::from(num_white) >= min_white * f64::from(seen)
        && f64::from(num_carpet) >= min_carpet * 2.0 * f64::from(seen);
    is_circle.then_some(f64::from(num_white) / f64::from(NUM_SAMPLES))
}

/// Unit vector in the image from a place on the ground outwards.
fn across_px(at: &Point2<f64>, outward: &Vector2<f64>, view: &GroundView) -> Option<Vector2<f64>> {
    let across = view.px(&(at + outward * 0.01))? - view.px(at)?;
    across.try_normalize(1e-9)
}

/// Whether a segment is a piece of the circle: its ends and its middle lie on it.
fn is_arc(segment: &Segment, center: &Point2<f64>, view: &GroundView, radius_m: f64) -> bool {
    let [a, b] = segment.ends_in_robot;
    let middle = view.ground(&nalgebra::center(&segment.ends_px()[0], &segment.ends_px()[1])).unwrap_or(a);
    segment.length_m() < 2.2 * radius_m
        && [a, middle, b].iter().all(|p| {
            let (_, near) = near_m(p, center, view);
            ((p - center).norm() - radius_m).abs() < 2.0 * near
        })
}

/// Direction of a line through the center.
fn halfway(segments: &[Segment], center: &Point2<f64>, view: &GroundView) -> Option<f64> {
    let through = segments.iter().filter(|segment| {
        let [a, b] = segment.ends_in_robot;
        let Some(along) = (b - a).try_normalize(1e-6) else { return false };
        let across = Vector2::new(-along.y, along.x);
        let off = (center - a).dot(&across).abs();
        off < HALFWAY_OFF_M + HALFWAY_OFF_PX * view.scale * view.meters_per_px(center, &across)
    });
    let longest = through.max_by(|a, b| a.length_m().total_cmp(&b.length_m()))?;
    let along = longest.ends_in_robot[1] - longest.ends_in_robot[0];
    Some(along.y.atan2(along.x).rem_euclid(PI))
}
