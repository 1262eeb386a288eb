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
