//! Where the lines of a field meet.

use nalgebra::{Point2, Vector2};

use super::{Field, Segment};

/// A place where lines meet.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldJunction {
    /// Where the center lines cross, (x, y) of the world, meters.
    pub at: Point2<f64>,
    /// Unit vectors along the lines that leave from there: two of a corner (L), three of a T, four of an X.
    pub arms: Vec<Vector2<f64>>,
    /// Whether one of the lines is the center circle, which the halfway line crosses at a right angle.
    pub is_on_circle: bool,
}

impl FieldJunction {
    /// The direction that tells its heading, a unit vector. L: between the two lines. T: along the line that ends. X: along
    /// one of the lines; a quarter turn more is the same.
    pub fn direction(&self) -> Vector2<f64> {
        let sum: Vector2<f64> = self.arms.iter().sum();
        sum.try_normalize(1e-6).or_else(|| self.arms.first().copied()).unwrap_or_else(Vector2::x)
    }
}

/// Two points nearer than this are one, meters.
const SAME_M: f64 = 1e-6;

/// All junctions of a field's long lines, and of its circle with the halfway line.
pub(super) fn junctions(field: &Field) -> Vec<FieldJunction> {
    let lines = field.lines();
    let mut junctions: Vec<FieldJunction> = Vec::new();
    for (i, a) in lines.iter().enumerate() {
        for b in &lines[i + 1..] {
            let Some(at) = crossing(a, b) else { continue };
            if junctions.iter().any(|j| (j.at - at).norm() < SAME_M) {
                continue;
            }
            junctions.push(FieldJunction { at, arms: arms(lines, &at), is_on_circle: false });
        }
    }
    let arms = vec![Vector2::x(), Vector2::y(), -Vector2::x(), -Vector2::y()];
    let on_circle = |y| FieldJunction { at: Point2::new(0.0, y), arms: arms.clone(), is_on_circle: true };
    let radius_m = field.circle_radius_m();
    junctions.extend([on_circle(radius_m), on_circle(-radius_m)]);
    junctions
}

/// Where two segments at right angles meet.
fn crossing(a: &Segment, b: &Segment) -> Option<Point2<f64>> {
    let (along_a, along_b) = (a.end - a.start, b.end - b.start);
    let turn = along_a.perp(&along_b);
    if turn.abs() < 1e-9 {
        return None;
    }
    let at = a.start + along_a * ((b.start - a.start).perp(&along_b) / turn);
    let is_on = |s: &Segment| (s.nearest_point(&at) - at).norm() < SAME_M;
    (is_on(a) && is_on(b)).then_some(at)
}

/// Directions in which lines leave from a point.
fn arms(lines: &[Segment], at: &Point2<f64>) -> Vec<Vector2<f64>> {
    let mut arms: Vec<Vector2<f64>> = Vec::new();
    for line in lines.iter().filter(|line| (line.nearest_point(at) - at).norm() < SAME_M) {
        for end in [line.start, line.end] {
            let Some(arm) = (end - at).try_normalize(SAME_M) else { continue };
            if arms.iter().all(|other| other.dot(&arm) < 0.99) {
                arms.push(arm);
            }
        }
    }
    arms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Map;

    fn count(name: &str) -> [usize; 3] {
        let Map::Field(field) = Map::built_in(name).unwrap() else { panic!("a field") };
        let junctions = field.junctions();
        [2, 3, 4].map(|n| junctions.iter().filter(|j| j.arms.len() == n && !j.is_on_circle).count())
    }

    #[test]
    fn fields_have_their_junctions() {
        // Four corners and two of each box; the halfway line ends on both side lines, each box twice on a goal line.
        assert_eq!(count("robocup-spl-2010"), [8, 6, 0]);
        for name in ["robocup-spl-2024", "robocup-humanoid-kid", "robocup-humanoid-adult"] {
            assert_eq!(count(name), [12, 10, 0], "{name}");
        }
    }

    #[test]
    fn directions_point_into_the_field() {
        let Map::Field(field) = Map::built_in("robocup-spl-2010").unwrap() else { panic!("a field") };
        let junctions = field.junctions();
        let at =
            |x: f64, y: f64| junctions.iter().find(|j| (j.at - Point2::new(x, y)).norm() < 1e-9).unwrap();
        assert!((at(3.0, 2.0).direction() - Vector2::new(-0.5, -0.5).normalize()).norm() < 1e-9);
        assert!((at(0.0, 2.0).direction() + Vector2::y()).norm() < 1e-9);
        assert!((at(-3.0, 1.1).direction() - Vector2::x()).norm() < 1e-9);
        assert_eq!(at(0.0, 0.6).arms.len(), 4);
    }
}
