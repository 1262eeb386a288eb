//! Smooth ways through points, walked with a trapezoidal speed profile.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point2, Vector2};
use visloc_core::geom::{PlanarPose, angle};

use super::plan::STEPS_PER_SEC;

/// Time for speeding up and for slowing down.
const RAMP_SECS: f64 = 1.0;
/// Standard deviation of the smoothing of the heading: a biped cannot turn at once.
const HEADING_SMOOTHING_SECS: f64 = 0.9;

/// A curve through points as a dense polyline with the length up to each vertex.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    points: Vec<Point2<f64>>,
    lengths_m: Vec<f64>,
}

impl Curve {
    /// A cubic Hermite spline with Catmull-Rom tangents that starts in direction `yaw_rad`.
    /// Source: Catmull, Rom, "A class of local interpolating splines", 1974.
    pub(super) fn new(start: &PlanarPose, through: &[Point2<f64>]) -> Self {
        const STEPS: usize = 40;
        let knots: Vec<Point2<f64>> =
            std::iter::once(start.position()).chain(through.iter().copied()).collect();
        let tangent = |i: usize| -> Vector2<f64> {
            if i == 0 {
                let reach = (knots[1] - knots[0]).norm().min(1.0);
                return Vector2::new(start.yaw_rad.cos(), start.yaw_rad.sin()) * reach;
            }
            let Some(next) = knots.get(i + 1) else { return (knots[i] - knots[i - 1]) * 0.5 };
            let tangent = (next - knots[i - 1]) * 0.5;
            // A tangent longer than the shorter piece beside it would make the curve swing out.
            let longest = (next - knots[i]).norm().min((knots[i] - knots[i - 1]).norm());
            tangent * (longest / tangent.norm().max(1e-9)).min(1.0)
        };
        let mut points = vec![knots[0]];
        for i in 0..knots.len() - 1 {
            let (from, to, leave, arrive) =
                (knots[i].coords, knots[i + 1].coords, tangent(i), tangent(i + 1));
            for step in 1..=STEPS {
                let s = step as f64 / STEPS as f64;
                let (s2, s3) = (s * s, s * s * s);
                let point = from * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + leave * (s3 - 2.0 * s2 + s)
                    + to * (3.0 * s2 - 2.0 * s3)
                    + arrive * (s3 - s2);
                points.push(Point2::from(point));
            }
        }
        let mut lengths_m = vec![0.0];
        for pair in points.windows(2) {
            lengths_m.push(lengths_m[lengths_m.len() - 1] + (pair[1] - pair[0]).norm());
        }
        Self { points, lengths_m }
    }

    pub(super) fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    pub(super) fn length_m(&self) -> f64 {
        self.lengths_m.last().copied().unwrap_or(0.0)
    }

    /// Cuts off what is longer than `length_m`.
    pub(super) fn truncate(&mut self, length_m: f64) {
        let keep = self.lengths_m.partition_point(|l| *l <= length_m).max(2);
        self.points.truncate(keep);
        self.lengths_m.truncate(keep);
    }

    /// The point after a way, and the direction there, radians.
    fn at(&self, way_m: f64) -> (Point2<f64>, f64) {
        let next = self.lengths_m.partition_point(|l| *l < way_m).clamp(1, self.points.len() - 1);
        let (from, to) = (self.points[next - 1], self.points[next]);
        let piece_m = (self.lengths_m[next] - self.lengths_m[next - 1]).max(1e-12);
        let along = to - from;
        let share = ((way_m - self.lengths_m[next - 1]) / piece_m).clamp(0.0, 1.0);
        (from + along * share, along.y.atan2(along.x))
    }

    /// The poses of somebody who walks the curve, one per step of the plan. The heading follows the curve smoothly and
    /// swings to its sides by up to `swing_rad`; it starts where `start_yaw_rad` (any number of turns) says.
    pub(super) fn walk(
        &self,
        start_yaw_rad: f64,
        speed_m_per_s: f64,
        swing_rad: f64,
    ) -> Vec<(Point2<f64>, f64)> {
        let length_m = self.length_m();
        let duration_secs = length_m / speed_m_per_s + RAMP_SECS;
        let num_steps = (duration_secs * STEPS_PER_SEC).ceil() as usize;
        let mut points = Vec::with_capacity(num_steps);
        let mut headings = Vec::with_capacity(num_steps);
        let mut heading_rad = start_yaw_rad;
        for step in 1..=num_steps {
            let secs = step as f64 / STEPS_PER_SEC;
            let way_m = way(secs, duration_secs) * length_m;
            let (point, direction_rad) = self.at(way_m);
            heading_rad += angle::difference(direction_rad, heading_rad);
            points.push(point);
            // Swings by one period in about six meters, starting at zero.
            headings.push(heading_rad + swing_rad * (way_m * 1.05).sin());
        }
        let mut smooth = smoothed(&headings, (HEADING_SMOOTHING_SECS * STEPS_PER_SEC) as usize);
        let first = smooth.first().copied().unwrap_or(start_yaw_rad);
        let jump_rad = start_yaw_rad - first;
        for (step, heading) in smooth.iter_mut().enumerate() {
            let secs = (step + 1) as f64 / STEPS_PER_SEC;
            *heading += jump_rad * (-(secs / 1.5).powi(2)).exp();
        }
        points.into_iter().zip(smooth).collect()
    }
}

/// Share of the way that is done after `secs`: speeds up for one ramp, slows down for one.
fn way(secs: f64, duration_secs: f64) -> f64 {
    let ramp = RAMP_SECS.min(duration_secs / 2.0);
    let full = duration_secs - ramp;
    let done = if secs < ramp {
        secs * secs / (2.0 * ramp)
    } else if secs < duration_secs - ramp {
        secs - ramp / 2.0
    } else {
        full - (duration_secs - secs).max(0.0).powi(2) / (2.0 * ramp)
    };
    (done / full).clamp(0.0, 1.0)
}

/// Three passes of a moving mean: nearly a Gaussian of the given standard deviation in samples.
fn smoothed(values: &[f64], deviation: usize) -> Vec<f64> {
    let mut current = values.to_vec();
    for _ in 0..3 {
        let mut sums = Vec::with_capacity(current.len() + 1);
        sums.push(0.0);
        for value in &current {
            sums.push(sums[sums.len() - 1] + value);
        }
        current = (0..current.len())
            .map(|i| {
                let reach = deviation.min(i).min(current.len() - 1 - i);
                (sums[i + reach + 1] - sums[i - reach]) / (2 * reach + 1) as f64
            })
            .collect();
    }
    current
}

/// Rises from 0 to 1 with soft ends while s goes from 0 to 1.
pub(super) fn ease(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    0.5 - 0.5 * (PI * s).cos()
}

/// The phase of something periodic, radians in [0, 2 pi).
pub(super) fn phase(secs: f64, period_secs: f64) -> f64 {
    (secs / period_secs).fract() * TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walk_passes_its_points_at_its_speed() {
        let through = [Point2::new(1.0, 0.5), Point2::new(2.0, -0.5), Point2::new(3.0, 0.0)];
        let curve = Curve::new(&PlanarPose::default(), &through);
        let poses = curve.walk(0.0, 0.25, 0.0);
        for point in through {
            let nearest = poses.iter().map(|(p, _)| (p - point).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.01, "{point} missed by {nearest} m");
        }
        let speeds: Vec<f64> =
            poses.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm() * STEPS_PER_SEC).collect();
        let fastest = speeds.iter().copied().fold(0.0, f64::max);
        assert!((fastest - 0.25).abs() < 0.02, "fastest {fastest}");
        assert!(speeds[0] < 0.01 && speeds[speeds.len() - 1] < 0.01);
    }

    #[test]
    fn heading_starts_where_the_robot_looks_and_follows_the_way() {
        let curve =
            Curve::new(&PlanarPose::new(0.0, 0.0, 2.0), &[Point2::new(2.0, 0.0), Point2::new(4.0, 0.0)]);
        let poses = curve.walk(2.0, 0.2, 0.0);
        assert!((poses[0].1 - 2.0).abs() < 0.01);
        let fastest_turn =
            poses.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs() * STEPS_PER_SEC).fold(0.0, f64::max);
        assert!(fastest_turn < 2.0, "{fastest_turn} rad/s");
        let last = poses[poses.len() - 1];
        assert!(angle::wrap(last.1).abs() < 0.05 && (last.0 - Point2::new(4.0, 0.0)).norm() < 1e-6);
    }
}
