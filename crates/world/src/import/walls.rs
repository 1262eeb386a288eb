//! Walls of drawings: filled shapes become their faces, and lines that lie on each other become one.

use std::collections::HashSet;

use i_overlay::{
    core::{fill_rule::FillRule, overlay_rule::OverlayRule},
    float::{overlay::FloatOverlay, simplify::SimplifyShape},
};

use super::drawing::{MIN_WALL_M, Solid, distance_m, rounded, sides};
use crate::office::check::MAX_WALLS;

/// A straight piece of a wall from end to end, meters.
pub(super) type Piece = [[f64; 2]; 2];

/// Lines nearer to each other than this lie on each other, and thinner walls are lines, meters.
const SAME_M: f64 = 0.02;
/// Shorter overlaps are only touches, as in the check of plans, meters.
const TOUCH_M: f64 = crate::office::check::TOUCH_M;

/// The faces of all filled shapes together, solid at the left, and the walls among them that are as thin as lines.
pub(super) fn faces_of(solids: &[Solid]) -> Result<(Vec<Piece>, Vec<Piece>), String> {
    let mut shapes = Vec::new();
    for solid in solids {
        let rule = if solid.is_even_odd { FillRule::EvenOdd } else { FillRule::NonZero };
        // Contours around an area go counterclockwise from here on, holes the other way.
        shapes.extend(solid.contours.simplify_shape(rule));
    }
    // Rounded, so that shapes that share a side in the drawing have the very same one.
    let rounded_contour =
        |contour: Vec<[f64; 2]>| contour.into_iter().map(|point| point.map(rounded)).collect();
    let contours: Vec<Vec<[f64; 2]>> = shapes.into_iter().flatten().map(rounded_contour).collect();
    if contours.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let union = FloatOverlay::with_subj(&contours).overlay(OverlayRule::Subject, FillRule::NonZero);
    let (mut faces, mut sheets) = (Vec::new(), Vec::new());
    for contour in union.into_iter().flatten() {
        let contour: Vec<[f64; 2]> = contour.into_iter().map(|point| point.map(rounded)).collect();
        let around_m: f64 = sides(&contour).map(|[a, b]| distance_m(&a, &b)).sum();
        let area_m2: f64 = 0.5 * sides(&contour).map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum::<f64>();
        if contour.len() <= 8 && area_m2.abs() < 0.5 * around_m * 1.5 * SAME_M {
            sheets.extend(longest(&contour));
        } else {
            faces.extend(sides(&contour).filter(|[from, to]| distance_m(from, to) >= MIN_WALL_M));
        }
    }
    if faces.len() > MAX_WALLS {
        return Err(format!("expected at most {MAX_WALLS} sides of filled walls, found {}", faces.len()));
    }
    Ok((faces, sheets))
}

/// The longest side of an outline that is worth a wall.
fn longest(contour: &[[f64; 2]]) -> Option<Piece> {
    let length = |piece: &Piece| distance_m(&piece[0], &piece[1]);
    let best = sides(contour).max_by(|a, b| length(a).total_cmp(&length(b)))?;
    (length(&best) >= MIN_WALL_M).then_some(best)
}

/// Lines without those that lie on `known` pieces; lines that lie on each other become one.
pub(super) fn merged(lines: Vec<Piece>, known: &[Piece]) -> Result<Vec<Piece>, String> {
    const MAX_LINES: usize = 40_000;
    const MAX_COMPARED: usize = 10_000_000;
    if lines.len() > MAX_LINES {
        let many = lines.len();
        return Err(format!("expected at most {MAX_LINES} pieces of walls, found {many}; leave out details"));
    }
    let lines = without_copies(lines);
    let is_known = |piece: &Piece| known.iter().any(|wall| is_near(wall, piece) && is_on(wall, piece));
    let lines: Vec<Piece> = lines.into_iter().filter(|piece| !is_known(piece)).collect();
    let (mut joined, mut num_compared): (Vec<usize>, usize) = ((0..lines.len()).collect(), 0);
    let mut order = joined.clone();
    let [min_x, max_x] = [f64::min, f64::max].map(|of| move |piece: &Piece| of(piece[0][0], piece[1][0]));
    order.sort_by(|a, b| min_x(&lines[*a]).total_cmp(&min_x(&lines[*b])).then(a.cmp(b)));
    for (i, a) in order.iter().enumerate() {
        let end = max_x(&lines[*a]) + SAME_M;
        for b in order[i + 1..].iter().take_while(|b| min_x(&lines[**b]) <= end) {
            if !is_near(&lines[*a], &lines[*b]) {
                continue;
            }
            num_compared += 1;
            if num_compared > MAX_COMPARED {
                return Err(
                    "expected a plan, found thousands of lines that lie close to each other".to_owned()
                );
            }
            if overlap_m(&lines[*a], &lines[*b]) > TOUCH_M {
                let (a, b) = (root(&mut joined, *a), root(&mut joined, *b));
                joined[a.max(b)] = a.min(b);
            }
        }
    }
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); lines.len()];
    for i in 0..lines.len() {
        members[root(&mut joined, i)].push(i);
    }
    let groups = members.iter().filter(|group| !group.is_empty());
    Ok(groups.map(|group| if let [one] = group[..] { lines[one] } else { spanned(&lines, group) }).collect())
}

/// Each line once, in the order of their first ones.
fn without_copies(lines: Vec<Piece>) -> Vec<Piece> {
    let mut known = HashSet::new();
    let bits = |end: &[f64; 2]| end.map(f64::to_bits);
    let key = |[a, b]: &Piece| if bits(a) < bits(b) { [bits(a), bits(b)] } else { [bits(b), bits(a)] };
    lines.into_iter().filter(|piece| known.insert(key(piece))).collect()
}

fn root(joined: &mut [usize], mut at: usize) -> usize {
    while joined[at] != at {
        joined[at] = joined[joined[at]];
        at = joined[at];
    }
    at
}

/// One line from the first to the last end of lines that lie on each other.
fn spanned(lines: &[Piece], group: &[usize]) -> Piece {
    let length = |i: &usize| distance_m(&lines[*i][0], &lines[*i][1]);
    let longest = group.iter().copied().max_by(|a, b| length(a).total_cmp(&length(b)).then(b.cmp(a)));
    let base = lines[longest.unwrap_or(group[0])];
    let ends = group.iter().flat_map(|i| lines[*i]);
    let along = |end: &[f64; 2]| place(&base, end).0;
    let (mut from, mut to) = (base[0], base[1]);
    for end in ends {
        if along(&end) < along(&from) {
            from = end;
        }
        if along(&end) > along(&to) {
            to = end;
        }
    }
    [from, to]
}

/// Where a point lies beside a piece: along it from its first end, and across it.
pub(super) fn place([from, to]: &Piece, at: &[f64; 2]) -> (f64, f64) {
    let length = distance_m(from, to).max(1e-9);
    let [ux, uy] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    let [x, y] = [at[0] - from[0], at[1] - from[1]];
    (x * ux + y * uy, x * uy - y * ux)
}

/// Whether the squares around two pieces touch; cheap, to be asked first.
pub(super) fn is_near(a: &Piece, b: &Piece) -> bool {
    const NEAR_M: f64 = 0.1;
    (0..2).all(|axis| {
        a[0][axis].min(a[1][axis]) <= b[0][axis].max(b[1][axis]) + NEAR_M
            && b[0][axis].min(b[1][axis]) <= a[0][axis].max(a[1][axis]) + NEAR_M
    })
}

/// Length for which a piece lies on another one.
pub(super) fn overlap_m(wall: &Piece, other: &Piece) -> f64 {
    let [(a, off_a), (b, off_b)] = [place(wall, &other[0]), place(wall, &other[1])];
    if off_a.abs().max(off_b.abs()) > SAME_M {
        return 0.0;
    }
    a.max(b).min(distance_m(&wall[0], &wall[1])) - a.min(b).max(0.0)
}

/// Whether all of a piece lies on another one.
fn is_on(wall: &Piece, piece: &Piece) -> bool {
    overlap_m(wall, piece) > distance_m(&piece[0], &piece[1]) - SAME_M
}
