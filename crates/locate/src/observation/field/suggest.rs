//! Poses that a piece of a line suggests.
//!
//! Three border pixels in a row on the ground are a piece of a straight border with its white on a known side. Laid on one
//! of the field's borders it leaves only the place along that border open, so some hundred suggestions cover a field.

use nalgebra::{Point2, Rotation2, Vector2};
use rand::RngExt;
use visloc_core::{Rng, geom::PlanarPose};

use super::outline::Outline;

/// Shortest and longest piece, meters.
const PIECE_M: std::ops::Range<f64> = 0.08..1.5;
/// A pixel between the ends is this near to the straight line, as a share of the piece, and directions are told apart from here on.
const STRAIGHTNESS: f64 = 0.06;
/// Pieces tried for one suggestion.
const TRIES: usize = 8;
/// Scan lines between the ends of a piece, at most.
const MAX_STEPS: usize = 6;

/// A border pixel of a line on the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroundBorder {
    /// Seen from the robot, meters.
    pub at: Point2<f64>,
    /// Towards the white, of any length.
    pub inward: Vector2<f64>,
}

/// Where the bars at the feet of nets lie: as wide as the goals, and this far behind the goal lines at most, meters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nets {
    pub goal_line_m: f64,
    pub half_goal_m: f64,
    pub depth_m: f64,
}

impl Nets {
    /// Both borders of both bars.
    fn length_m(&self) -> f64 {
        8.0 * self.half_goal_m
    }

    /// A point on a border, with the direction towards its white. The map does not say how deep nets are.
    fn random_point(&self, rng: &mut Rng) -> (Point2<f64>, Vector2<f64>) {
        let x_m = self.goal_line_m + rng.random_range(0.0..self.depth_m);
        let y_m = rng.random_range(-self.half_goal_m..self.half_goal_m);
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let inward = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        (Point2::new(side * x_m, y_m), Vector2::new(inward, 0.0))
    }
}

/// A pose at which a piece of a line, taken at random, lies on a border of the field or on the bar at the foot of a net.
pub(super) fn pose_from_line(
    borders: &[GroundBorder],
    outlines: &[Outline],
    nets: &Nets,
    rng: &mut Rng,
) -> Option<PlanarPose> {
    let (middle, inward) = (0..TRIES).find_map(|_| piece(borders, rng))?;
    let (point, target_inward) = random_point(outlines, nets, rng);
    let yaw_rad = target_inward.y.atan2(target_inward.x) - inward.y.atan2(inward.x);
    let offset = Rotation2::new(yaw_rad) * middle.coords;
    Some(PlanarPose::new(point.x - offset.x, point.y - offset.y, yaw_rad))
}

/// Middle of a straight piece and the direction towards its white, seen from the robot.
fn piece(borders: &[GroundBorder], rng: &mut Rng) -> Option<(Point2<f64>, Vector2<f64>)> {
    if borders.len() < 3 {
        return None;
    }
    let first = rng.random_range(0..borders.len() - 2);
    let a = borders[first];
    let last = (first + 2 * MAX_STEPS).min(borders.len() - 1);
    let c = borders[rng.random_range(first + 2..=last)];
    let along = c.at - a.at;
    let length = along.norm();
    if !PIECE_M.contains(&length) {
        return None;
    }
    let across = Vector2::new(-along.y, along.x) / length;
    // Pixels of one scan line have their white along it, on neither side.
    let has_white =
        |b: &GroundBorder, side: f64| side * b.inward.dot(&across) > STRAIGHTNESS * b.inward.norm();
    let side = [1.0, -1.0].into_iter().find(|side| has_white(&a, *side) && has_white(&c, *side))?;
    let is_between = |b: &GroundBorder| {
        let offset = b.at - a.at;
        let t = offset.dot(&along) / (length * length);
        (0.2..0.8).contains(&t) && offset.dot(&across).abs() < STRAIGHTNESS * length && has_white(b, side)
    };
    let middle = borders[first + 1..last].iter().find(|b| is_between(b))?;
    Some((middle.at, across * side))
}

/// A random point on a straight border of the field or of the bar at the foot of a net, with the direction towards its white.
fn random_point(outlines: &[Outline], nets: &Nets, rng: &mut Rng) -> (Point2<f64>, Vector2<f64>) {
    let total = outlines.iter().map(length).sum::<f64>() + nets.length_m();
    let mut at = rng.random_range(0.0..total);
    for outline in outlines {
        let length = length(outline);
        if at < length
            && let Outline::Segment { start, along, inward, .. } = outline
        {
            return (start + along * (at / length), *inward);
        }
        at -= length;
    }
    nets.random_point(rng)
}

fn length(outline: &Outline) -> f64 {
    match outline {
        Outline::Segment { along, .. } => along.norm(),
        Outline::Circle { .. } => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn the_bar_at_the_foot_of_a_net_leads_near_the_true_pose() {
        let truth = PlanarPose::new(2.0, 1.0, 0.3);
        let nets = Nets { goal_line_m: 3.0, half_goal_m: 0.75, depth_m: 1.0 };
        let border = |y_m: f64| GroundBorder {
            at: truth.inverse().transform(&Point2::new(3.45, y_m)),
            inward: Rotation2::new(-truth.yaw_rad) * Vector2::x(),
        };
        let borders: Vec<_> = (0..9).map(|i| border(0.05 * f64::from(i))).collect();
        let mut rng = RngTree::new(1).stream("suggest", 0);
        let is_near =
            |pose: &PlanarPose| pose.distance_m(&truth) < 0.3 && pose.heading_difference_rad(&truth) < 1e-6;
        let found = (0..400).filter_map(|_| pose_from_line(&borders, &[], &nets, &mut rng));
        assert!(found.filter(is_near).count() >= 5);
    }
}
