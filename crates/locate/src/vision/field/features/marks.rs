//! Penalty marks: small white things of the known size with carpet all around.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};

use super::{
    crossings::Crossing,
    segments::Segment,
    view::{GroundView, Seen},
};
use crate::vision::PenaltyMark;

/// A crossing of a mark is at most this many times as long as the mark, and a pixel.
const MAX_CHORD: f64 = 1.3;
/// Marks farther away than this are too flat, meters.
const MAX_DISTANCE_M: f64 = 3.5;
/// Two marks are farther apart, meters.
const MIN_APART_M: f64 = 0.3;
/// Samples around a mark; so many must be carpet.
const NUM_SAMPLES: u32 = 16;
const MIN_CARPET: u32 = 15;
/// Its length and its width in the image, as shares of what its size demands.
const MIN_EXTENT: f64 = 0.55;
const MAX_EXTENT: f64 = 1.5;

/// All marks near crossings that belong to no line.
pub(super) fn find(
    crossings: &[Crossing],
    segments: &[Segment],
    view: &GroundView,
    mark_size_m: f64,
    out: &mut Vec<PenaltyMark>,
) {
    for crossing in crossings {
        let distance_m = crossing.ground.coords.norm();
        if distance_m > MAX_DISTANCE_M
            || crossing.chord.norm() > MAX_CHORD * mark_size_m + 2.0 * view.blur * px_m(crossing)
        {
            continue;
        }
        let is_known = |mark: &PenaltyMark| (mark.at_in_robot - crossing.ground).norm() < MIN_APART_M;
        if out.iter().any(is_known) || segments.iter().any(|s| is_on_line(s, &crossing.px, view)) {
            continue;
        }
        out.extend(mark_at(crossing, view, mark_size_m));
    }
}

/// Length of a pixel along a crossing, meters.
fn px_m(crossing: &Crossing) -> f64 {
    crossing.chord.norm() / crossing.run_px
}

fn is_on_line(segment: &Segment, px: &Point2<f64>, view: &GroundView) -> bool {
    let position = segment.line.position(px);
    segment.line.distance(px) < 2.0 * view.scale
        && position > segment.from - 2.0 * view.scale
        && position < segment.to + 2.0 * view.scale
}

/// Goes to the middle of the white around a crossing, and compares its size and what is around it.
fn mark_at(crossing: &Crossing, view: &GroundView, mark_size_m: f64) -> Option<PenaltyMark> {
    let white = crossing.white;
    let mut middle = crossing.px;
    let ahead = crossing.ground.coords.normalize();
    let size_px = [Vector2::new(-ahead.y, ahead.x), ahead]
        .map(|direction| mark_size_m / view.meters_per_px(&crossing.ground, &direction));
    let mut extent = [0.0; 2];
    for _ in 0..2 {
        for (axis, direction) in [Vector2::x(), Vector2::y()].into_iter().enumerate() {
            let limit = MAX_EXTENT * size_px[axis] + 2.0 * view.blur;
            let before = white_length(&middle, -direction, limit, white, view);
            let after = white_length(&middle, direction, limit, white, view);
            middle += direction * ((after - before) / 2.0);
            extent[axis] = before + after + 1.0;
        }
    }
    // A pixel more or less is always possible.
    let fits = |axis: usize| {
        extent[axis] >= MIN_EXTENT * size_px[axis] - view.blur
            && extent[axis] <= MAX_EXTENT * size_px[axis] + view.blur
    };
    let at = view.ground(&middle)?;
    let is_mark = fits(0) && fits(1) && view.at_px(&middle, white) == Seen::White;
    (is_mark && has_carpet_around(&at, view, mark_size_m, white))
        .then_some(PenaltyMark { at_in_robot: at, at_px: middle })
}

/// How far it is white from a pixel on, pixels.
fn white_length(
    from: &Point2<f64>,
    direction: Vector2<f64>,
    limit: f64,
    white: u32,
    view: &GroundView,
) -> f64 {
    let mut length = 0.0;
    while length < limit && view.at_px(&(from + direction * (length + 1.0)), white) == Seen::White {
        length += 1.0;
    }
    length
}

fn has_carpet_around(at: &Point2<f64>, view: &GroundView, mark_size_m: f64, white: u32) -> bool {
    let carpet = (0..NUM_SAMPLES).filter(|i| {
        let (sin, cos) = (f64::from(*i) / f64::from(NUM_SAMPLES) * TAU).sin_cos();
        let outward = Vector2::new(cos, sin);
        let radius = mark_size_m / 2.0 + 0.03 + 2.0 * view.scale * view.meters_per_px(at, &outward);
        let px = view.px(&(at + outward * radius));
        px.is_some_and(|px| view.at_px(&px, white) == Seen::Carpet)
    });
    carpet.count() >= MIN_CARPET as usize
}
