//! What walls hide of a line.

use nalgebra::Point2;
use visloc_world::office::Wall;

use super::lines::TheoreticalLine;

/// A wall does not hide what is so near to the way's ends: the line itself lies on a wall, meters.
pub(super) const SLACK_M: f64 = 0.03;
/// A shorter rest of a line is not seen, meters.
const MIN_REST_M: f64 = 0.02;

/// Whether a place is on the side from which a line is seen.
#[inline]
pub(super) fn faces(from: &Point2<f64>, line: &TheoreticalLine) -> bool {
    (from - line.start).dot(&line.normal) > 0.0
}

/// The part of a line that walls leave to an eye that faces it, as shares of its length; `None` if they hide it all. Of two
/// parts with a wall's shadow between them it is the longer one.
#[inline]
pub(super) fn part_seen<'a>(
    eye: &Point2<f64>,
    line: &TheoreticalLine,
    mut walls: impl Iterator<Item = &'a Wall>,
) -> Option<[f64; 2]> {
    let whole = line.end - line.start;
    let length_m = whole.norm();
    if length_m < MIN_REST_M {
        let is_hidden = walls.any(|wall| wall.hides(eye, &line.start, SLACK_M));
        return (!is_hidden).then_some([0.0, 1.0]);
    }
    // Places along the line and before it, meters.
    let along = whole / length_m;
    let place = |point: &Point2<f64>| {
        let offset = point - line.start;
        [offset.dot(&along), offset.dot(&line.normal)]
    };
    let [eye_along, eye_before] = place(eye);
    let shadow =
        |[along, before]: [f64; 2]| eye_along + (along - eye_along) * eye_before / (eye_before - before);
    let [mut from, mut to] = [0.0, length_m];
    for wall in walls {
        let ends = [place(&wall.start), place(&wall.end)];
        let Some(ends) = between(ends, [SLACK_M, eye_before - SLACK_M]) else { continue };
        let [a, b] = ends.map(shadow);
        let (begin, end) = (a.min(b), a.max(b));
        if end <= from || begin >= to {
            continue;
        }
        if begin - from > to - end {
            to = begin;
        } else {
            from = end;
        }
        if to - from < MIN_REST_M {
            return None;
        }
    }
    Some([from / length_m, to / length_m])
}

/// The part of a wall that lies between two distances before a line.
#[inline]
fn between([a, b]: [[f64; 2]; 2], [min, max]: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let (nearest, farthest) = (a[1].min(b[1]), a[1].max(b[1]));
    if farthest <= min || nearest >= max || min >= max {
        return None;
    }
    let at = |before: f64| {
        let t = (before - a[1]) / (b[1] - a[1]);
        [a[0] + t * (b[0] - a[0]), before]
    };
    Some([a, b].map(|end| if (min..=max).contains(&end[1]) { end } else { at(end[1].clamp(min, max)) }))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::vision::FeatureKind;

    /// A border from (0, 0) to (4, 0), seen from above.
    fn border() -> TheoreticalLine {
        TheoreticalLine {
            kind: FeatureKind::WallFoot,
            start: Point2::new(0.0, 0.0),
            end: Point2::new(4.0, 0.0),
            end_height_m: 0.0,
            normal: Vector2::new(0.0, 1.0),
        }
    }

    fn wall(from: (f64, f64), to: (f64, f64)) -> Wall {
        Wall { start: Point2::new(from.0, from.1), end: Point2::new(to.0, to.1), origin: String::new() }
    }

    fn part(eye: (f64, f64), walls: &[Wall]) -> Option<[f64; 2]> {
        part_seen(&Point2::new(eye.0, eye.1), &border(), walls.iter())
    }

    #[test]
    fn a_wall_cuts_where_its_shadow_falls() {
        assert_eq!(part((2.0, 2.0), &[]), Some([0.0, 1.0]));
        // Halfway between: its end at x = 1.5 throws its shadow to x = 1.
        for ends in [((-1.0, 1.0), (1.5, 1.0)), ((1.5, 1.0), (-1.0, 1.0))] {
            let [from, to] = part((2.0, 2.0), &[wall(ends.0, ends.1)]).unwrap();
            assert!((from - 0.25).abs() < 1e-9 && (to - 1.0).abs() < 1e-9, "{from} {to}");
        }
        let two = [wall((-1.0, 1.0), (1.5, 1.0)), wall((2.5, 1.0), (9.0, 1.0))];
        let [from, to] = part((2.0, 2.0), &two).unwrap();
        assert!((from - 0.25).abs() < 1e-9 && (to - 0.75).abs() < 1e-9, "{from} {to}");
        assert_eq!(part((2.0, 2.0), &[wall((-9.0, 1.0), (9.0, 1.0))]), None);
    }

    #[test]
    fn of_two_parts_the_longer_one_is_seen() {
        // A shadow from x = 0.8 to x = 1.6.
        let [from, to] = part((2.0, 2.0), &[wall((1.4, 1.0), (1.8, 1.0))]).unwrap();
        assert!((from - 0.4).abs() < 1e-9 && (to - 1.0).abs() < 1e-9, "{from} {to}");
    }

    #[test]
    fn walls_behind_the_eye_or_the_border_and_its_own_wall_hide_nothing() {
        let harmless = [
            wall((-9.0, 3.0), (9.0, 3.0)),
            wall((-9.0, -1.0), (9.0, -1.0)),
            wall((0.0, 0.0), (4.0, 0.0)),
            wall((4.0, 0.0), (4.0, 5.0)),
        ];
        assert_eq!(part((2.0, 2.0), &harmless), Some([0.0, 1.0]));
    }

    #[test]
    fn a_wall_that_reaches_past_the_eye_hides_one_side() {
        let [from, to] = part((2.0, 2.0), &[wall((1.5, 1.0), (1.5, 9.0))]).unwrap();
        assert!((from - 0.25).abs() < 1e-9 && (to - 1.0).abs() < 1e-9, "{from} {to}");
    }
}
