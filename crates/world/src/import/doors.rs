//! Doors of drawings: lines in a wall or in the gap between two, and the swings of leaves.

use super::{
    drawing::{GAP_M, Stroke, distance_m},
    notes::Notes,
    walls::{Piece, is_near, overlap_m, place},
};
use crate::office::{
    SurfaceColor,
    check::{MAX_DOORS, TOUCH_M},
};

/// A stroke that stands for a door, or for a part of one.
#[derive(Debug)]
pub(super) struct Door<'a> {
    pub stroke: &'a Stroke,
    pub points: Vec<[f64; 2]>,
    pub color: Option<SurfaceColor>,
    pub is_open: bool,
}

/// A door where it belongs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedDoor {
    pub ends: Piece,
    pub color: Option<SurfaceColor>,
    pub is_open: bool,
    /// The wall behind it, if it closes a gap between walls.
    pub fill: Option<Piece>,
}

/// How a door fits.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fit {
    Gap,
    OnWall,
}

/// The doors that fit into the walls. A swing's leaf stands in the wall when it is closed: a quarter of a circle has its
/// hinge in the middle, and one of its ends is where the closed leaf reaches.
pub(super) fn place_doors(
    doors: &[Door<'_>],
    walls: &[Piece],
    notes: &mut Notes,
) -> Result<Vec<PlacedDoor>, String> {
    if doors.len() > 4 * MAX_DOORS {
        return Err(format!("expected at most {} strokes of doors, found {}", 4 * MAX_DOORS, doors.len()));
    }
    let mut placed: Vec<PlacedDoor> = Vec::new();
    let is_together =
        |a: &Door<'_>, b: &Door<'_>| a.stroke.block.is_some() && a.stroke.block == b.stroke.block;
    for group in doors.chunk_by(is_together) {
        let part = &group[0].stroke.part;
        let found = found_in(group, walls);
        let has_swing = group.iter().any(|door| !swings(door).is_empty());
        let reason = match (found.is_empty(), has_swing) {
            (true, true) => "no wall within 5 cm of where its swing begins and ends",
            (true, false) => "no wall within 5 cm of both ends of this door, as of a leaf that stands open",
            _ => "",
        };
        if found.is_empty() {
            notes.passed_over(part, reason);
        }
        for (door, ends, fit) in found {
            if placed.iter().any(|other| is_near(&other.ends, &ends) && lies_over(&other.ends, &ends)) {
                notes.passed_over(part, "another door is in its place");
                continue;
            }
            let fill = (fit == Fit::Gap).then(|| fill(&ends, walls));
            placed.push(PlacedDoor { ends, color: door.color, is_open: door.is_open, fill });
            if door.stroke.block.is_some() || has_swing {
                notes.taken(part, "as a door");
            }
        }
    }
    Ok(placed)
}

/// The doors that the strokes of one block, or a single stroke, stand for.
fn found_in<'d, 'a>(group: &'d [Door<'a>], walls: &[Piece]) -> Vec<(&'d Door<'a>, Piece, Fit)> {
    let mut found = Vec::new();
    for door in group {
        for candidates in swings(door) {
            let fits = candidates.iter().filter_map(|ends| Some((door, *ends, fit(ends, walls)?)));
            // What closes a gap is a door more surely than what leans against a wall.
            found.extend(fits.min_by_key(|(_, _, fit)| *fit != Fit::Gap));
        }
    }
    if found.is_empty() {
        let spans = group.iter().filter_map(|door| Some((door, span(door)?)));
        let fits = spans.filter_map(|(door, ends)| Some((door, ends, fit(&ends, walls)?)));
        let length = |ends: &Piece| distance_m(&ends[0], &ends[1]);
        found.extend(fits.max_by(|a, b| length(&a.1).total_cmp(&length(&b.1))));
    }
    found
}

/// Whether both ends of a door lie on one wall, or it reaches from one wall to another.
fn fit(ends: &Piece, walls: &[Piece]) -> Option<Fit> {
    let near: Vec<&Piece> = walls.iter().filter(|wall| is_near(wall, ends)).collect();
    let holds = |wall: &&&Piece| {
        let length_m = distance_m(&wall[0], &wall[1]);
        ends.iter().all(|end| {
            let (along, across) = place(wall, end);
            across.abs() <= GAP_M && along >= -GAP_M && along <= length_m + GAP_M
        })
    };
    if near.iter().any(|wall| holds(&wall)) {
        return Some(Fit::OnWall);
    }
    let touches = |end: &[f64; 2]| near.iter().any(|wall| distance_from_m(wall, end) < GAP_M);
    ends.iter().all(touches).then_some(Fit::Gap)
}

/// The wall behind a door in a gap: to the ends of the walls beside it if it would lie on them otherwise.
fn fill(ends: &Piece, walls: &[Piece]) -> Piece {
    let near = || walls.iter().filter(|wall| is_near(wall, ends));
    if !near().any(|wall| overlap_m(wall, ends) > TOUCH_M) {
        return *ends;
    }
    ends.map(|end| {
        let corners = near().flatten().filter(|corner| distance_m(corner, &end) < GAP_M);
        corners.min_by(|a, b| distance_m(a, &end).total_cmp(&distance_m(b, &end))).copied().unwrap_or(end)
    })
}

/// Whether two doors are in the same place of a wall.
fn lies_over(one: &Piece, other: &Piece) -> bool {
    let [(a, off_a), (b, off_b)] = [place(one, &other[0]), place(one, &other[1])];
    let shared_m = a.max(b).min(distance_m(&one[0], &one[1])) - a.min(b).max(0.0);
    off_a.abs().max(off_b.abs()) <= 2.0 * GAP_M && shared_m > TOUCH_M
}

/// Both places of a leaf, from its hinge to either end of its swing, for each arc of a stroke.
fn swings(door: &Door<'_>) -> Vec<[Piece; 2]> {
    let of = |[from, to]: &[usize; 2]| {
        let curve = door.points.get(*from..=*to)?;
        let (start, middle, end) = (curve.first()?, curve.get(curve.len() / 2)?, curve.last()?);
        let hinge = circle_center(start, middle, end)?;
        let radius = distance_m(&hinge, start);
        let is_round = curve.iter().all(|point| (distance_m(&hinge, point) - radius).abs() < 0.05 * radius);
        // A swing of 30 to 180 degrees.
        let is_swing = distance_m(start, end) > 0.5 * radius && distance_m(start, middle) < 1.5 * radius;
        (is_round && is_swing).then_some([[hinge, *start], [hinge, *end]])
    };
    door.stroke.lines.curves.iter().filter_map(of).collect()
}

/// The middle of the circle through three points.
fn circle_center(a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]) -> Option<[f64; 2]> {
    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
    let twice = 2.0 * (bx * cy - by * cx);
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    let center = [a[0] + (cy * b2 - by * c2) / twice, a[1] + (bx * c2 - cx * b2) / twice];
    (twice.abs() > 1e-9).then_some(center)
}

/// A door's edges: a leaf drawn with its thickness has them in the middle of its short sides, everything else where its
/// points are farthest apart.
fn span(door: &Door<'_>) -> Option<Piece> {
    let points = &door.points;
    if let ([a, b, c, d], true) = (&points[..], door.stroke.lines.is_closed) {
        let middle = |p: &[f64; 2], q: &[f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let is_ab_short = distance_m(a, b) + distance_m(c, d) < distance_m(b, c) + distance_m(d, a);
        return Some(if is_ab_short { [middle(a, b), middle(c, d)] } else { [middle(b, c), middle(d, a)] });
    }
    let farthest_from = |from: &[f64; 2]| {
        points.iter().copied().max_by(|a, b| distance_m(a, from).total_cmp(&distance_m(b, from)))
    };
    let to = farthest_from(points.first()?)?;
    let from = farthest_from(&to)?;
    (distance_m(&from, &to) >= GAP_M).then_some([from, to])
}

/// Distance of a point from a wall, ends included.
fn distance_from_m(wall: &Piece, at: &[f64; 2]) -> f64 {
    let length_m = distance_m(&wall[0], &wall[1]);
    let (along, across) = place(wall, at);
    across.hypot((along - along.clamp(0.0, length_m)).abs())
}
