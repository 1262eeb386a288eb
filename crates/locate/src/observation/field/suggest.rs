//! Poses that pieces of lines suggest.
//!
//! Three border pixels in a row on the ground are a piece of a border with its white on a known side. A straight one that is laid on one
//! of the field's borders leaves only the place along that border open, so some hundred suggestions cover a field. One that is bent
//! as the center circle tells where the circle's center is, and a straight one how the field is turned, up to quarter turns: where the
//! camera looks elsewhere than reported, the circle as a whole is not found.

use nalgebra::{Point2, Vector2};
use rand::RngExt;
use visloc_core::{Rng, geom::PlanarPose};

use super::{
    composites::{align, heading, quarter_turns},
    outline::Outline,
};

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

/// Three border pixels in a row, as a part of the field.
#[derive(Debug, Clone, Copy)]
enum Piece {
    /// Of a straight border: its middle and the direction towards its white.
    Straight { middle: Point2<f64>, inward: Vector2<f64> },
    /// Of a border of the center circle.
    Arc { center: Point2<f64> },
}

/// A pose at which a piece of a line, taken at random, lies on a border of the field or on the bar at the foot of a net.
pub(super) fn pose_from_line(
    borders: &[GroundBorder],
    outlines: &[Outline],
    nets: &Nets,
    rng: &mut Rng,
) -> Option<PlanarPose> {
    match (0..TRIES).find_map(|_| piece(borders, outlines, rng))? {
        Piece::Straight { middle, inward } => {
            let (point, target_inward) = random_point(outlines, nets, rng);
            Some(align(&middle, &point, heading(&target_inward) - heading(&inward)))
        }
        Piece::Arc { center } => {
            let straight = |_| match piece(borders, outlines, rng)? {
                Piece::Straight { inward, .. } => Some(inward),
                Piece::Arc { .. } => None,
            };
            let inward = (0..TRIES).find_map(straight)?;
            Some(align(&center, &Point2::origin(), quarter_turns(rng) - heading(&inward)))
        }
    }
}

/// Three pixels of one border, in the order of the scan lines, seen from the robot.
fn piece(borders: &[GroundBorder], outlines: &[Outline], rng: &mut Rng) -> Option<Piece> {
    if borders.len() < 3 {
        return None;
    }
    let first = rng.random_range(0..borders.len() - 2);
    let a = borders[first];
    let last = (first + 2 * MAX_STEPS).min(borders.len() - 1);
    let last = rng.random_range(first + 2..=last);
    let c = borders[last];
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
    let inward = across * side;
    let centers = outlines.iter().filter_map(|outline| center(outline, &a.at, &c.at, &inward));
    borders[first + 1..last].iter().find_map(|b| {
        let offset = b.at - a.at;
        let t = offset.dot(&along) / (length * length);
        if !(0.2..0.8).contains(&t) || !has_white(b, side) {
            return None;
        }
        let is_near = |distance_m: f64| distance_m.abs() < STRAIGHTNESS * length;
        if is_near(offset.dot(&across)) {
            return Some(Piece::Straight { middle: b.at, inward });
        }
        let mut centers = centers.clone();
        let (center, _) = centers.find(|(center, radius_m)| is_near((b.at - center).norm() - radius_m))?;
        Some(Piece::Arc { center })
    })
}

/// Where the center of a circle is, with its radius, if two points are on it, with their white at this side of the straight line between them.
fn center(
    outline: &Outline,
    a: &Point2<f64>,
    c: &Point2<f64>,
    inward: &Vector2<f64>,
) -> Option<(Point2<f64>, f64)> {
    let Outline::Circle { radius_m, is_outer } = outline else { return None };
    let middle = nalgebra::center(a, c);
    let height_m = (radius_m * radius_m - (c - middle).norm_squared()).max(0.0).sqrt();
    let toward = if *is_outer { *inward } else { -inward };
    Some((middle + toward * height_m, *radius_m))
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
    use nalgebra::Rotation2;
    use visloc_core::RngTree;

    use super::*;

    /// Pixels of both borders of a piece of the circle and of the halfway line.
    #[test]
    fn a_piece_of_the_circle_and_one_of_a_line_lead_near_the_true_pose() {
        let truth = PlanarPose::new(-1.5, 0.4, 0.3);
        let seen = |at: Point2<f64>, inward: Vector2<f64>| GroundBorder {
            at: truth.inverse().transform(&at),
            inward: Rotation2::new(-truth.yaw_rad) * inward,
        };
        let circles = [0.725, 0.775].map(|radius_m| Outline::Circle { radius_m, is_outer: radius_m > 0.75 });
        let mut borders = Vec::new();
        for circle in &circles {
            let Outline::Circle { radius_m, .. } = circle else { continue };
            let at = |i: i32| Rotation2::new(2.0 + 0.1 * f64::from(i)) * Point2::new(*radius_m, 0.0);
            borders.extend((0..15).map(at).map(|at| seen(at, circle.inward(&at))));
        }
        borders.extend((0..15).map(|i| seen(Point2::new(0.025, 0.05 * f64::from(i)), -Vector2::x())));
        let nets = Nets { goal_line_m: 3.0, half_goal_m: 0.75, depth_m: 1.0 };
        let mut rng = RngTree::new(1).stream("suggest", 0);
        let is_near =
            |pose: &PlanarPose| pose.distance_m(&truth) < 0.3 && pose.heading_difference_rad(&truth) < 0.1;
        let found = (0..400).filter_map(|_| pose_from_line(&borders, &circles, &nets, &mut rng));
        let num_near = found.filter(is_near).count();
        assert!(num_near >= 20, "{num_near}");
    }

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
