//! From the strokes of a drawing to a plan: which stroke is a wall, a corridor or a door.

use super::{
    doors::{Door, place_doors},
    found_nothing,
    notes::{Import, Notes, Part},
    walls::{self, Piece},
};
use crate::office::{
    CorridorPlan, DoorPlan, OfficePlan, SurfaceColor, WallPlan, WallSides,
    check::{MAX_COORDINATE_M, MAX_WALLS},
};

/// What a stroke stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Role {
    Wall,
    /// A floor with walls all around.
    Corridor,
    Door {
        color: Option<SurfaceColor>,
        is_open: bool,
    },
}

/// Straight lines from point to point, meters in the map.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Lines {
    pub points: Vec<[f64; 2]>,
    pub is_closed: bool,
    /// First and last index of the points that lie on one curve.
    pub curves: Vec<[usize; 2]>,
}

/// Lines with what they stand for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stroke {
    pub role: Role,
    pub lines: Lines,
    /// Strokes of a block belong together.
    pub block: Option<usize>,
    pub part: Part,
}

/// Filled outlines of walls: what is inside is solid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solid {
    pub contours: Vec<Vec<[f64; 2]>>,
    pub is_even_odd: bool,
}

/// All that a file draws.
#[derive(Debug, Default)]
pub(super) struct Drawing {
    pub strokes: Vec<Stroke>,
    pub solids: Vec<Solid>,
    pub notes: Notes,
}

/// Names say what a stroke is; the first that says something counts. Layers of architects' drawings are called `A-WALL` or
/// `A-DOOR`, so a part of the name suffices.
pub(super) fn role_by_name<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<Role> {
    names.into_iter().find_map(|name| {
        // What is bound into another drawing has that drawing's name in front: `FLOOR-2$0$A-WALL`.
        let name = name.rsplit('$').next().unwrap_or(name).to_lowercase();
        if name.contains("door") {
            Some(Role::Door { color: None, is_open: name.contains("open") })
        } else if name.contains("corridor") || name.contains("floor") {
            Some(Role::Corridor)
        } else {
            name.contains("wall").then_some(Role::Wall)
        }
    })
}

/// Points that are this near to each other are the same, meters.
pub(super) const GAP_M: f64 = 0.05;
/// Shorter pieces of walls are left out: rests of rounding, meters.
pub(super) const MIN_WALL_M: f64 = 0.05;
/// No building is smaller, meters: a drawing that is has another unit than it says.
pub(super) const MIN_BUILDING_M: f64 = 1.0;
/// How far a curve is off the straight lines that stand for it, meters.
pub(super) const FLAT_M: f64 = 0.005;
/// What a drawing without walls lacks.
const NO_WALLS: &str = "expected at least one wall";
/// More points are no plan.
pub(super) const MAX_POINTS: usize = 200_000;

/// The plan of a drawing. Where a wall is interrupted by a door, the wall goes on behind it. The error says what there is
/// too much of.
pub(super) fn plan_of(title: &str, drawing: Drawing) -> Result<Import, String> {
    let Drawing { strokes, solids, mut notes } = drawing;
    let is_door = |stroke: &Stroke| matches!(stroke.role, Role::Door { .. });
    if solids.is_empty() && strokes.iter().all(is_door) {
        return Err(found_nothing(NO_WALLS, notes));
    }
    refuse_tiny(
        strokes
            .iter()
            .flat_map(|s| &s.lines.points)
            .chain(solids.iter().flat_map(|s| s.contours.iter().flatten())),
    )?;
    let mut plan = OfficePlan::named(title);
    let (mut lines, mut doors) = (Vec::new(), Vec::new());
    for stroke in &strokes {
        let points: Vec<[f64; 2]> = stroke.lines.points.iter().map(|point| point.map(rounded)).collect();
        match stroke.role {
            Role::Corridor => {
                let outline = without_short_sides(&points);
                if outline.len() >= 3 {
                    plan.corridors.push(CorridorPlan::closed(outline));
                } else {
                    notes.passed_over(&stroke.part, "a corridor has at least three corners");
                }
            }
            Role::Wall => {
                let closing = (stroke.lines.is_closed && !points.is_empty())
                    .then(|| [points[points.len() - 1], points[0]]);
                let pieces = points.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing);
                lines.extend(pieces.filter(|[from, to]| distance_m(from, to) >= MIN_WALL_M));
            }
            Role::Door { color, is_open } => doors.push(Door { stroke, points, color, is_open }),
        }
    }
    let (faces, sheets) = walls::faces_of(&solids)?;
    lines.extend(sheets);
    let sides = plan.corridors.iter().flat_map(|corridor| sides(&corridor.outline));
    let known: Vec<Piece> = sides.chain(faces.iter().copied()).collect();
    let lines = walls::merged(lines, &known)?;
    let wall = |[from, to]: &Piece, sides| WallPlan { from: *from, to: *to, sides };
    plan.walls.extend(lines.iter().map(|piece| wall(piece, WallSides::Both)));
    plan.walls.extend(faces.iter().map(|piece| wall(piece, WallSides::Right)));
    let pieces: Vec<Piece> = lines.into_iter().chain(known).collect();
    if pieces.len() > MAX_WALLS {
        let num = pieces.len();
        return Err(format!(
            "expected at most {MAX_WALLS} walls, found {num}; leave out furniture and other details"
        ));
    }
    let placed = place_doors(&doors, &pieces, &mut notes)?;
    for door in placed {
        plan.walls.extend(door.fill.iter().map(|piece| wall(piece, WallSides::Both)));
        let [from, to] = door.ends;
        let color = door.color.unwrap_or(SurfaceColor::RED);
        plan.doors.push(DoorPlan { from, to, height_m: 2.05, color, is_open: door.is_open });
    }
    if plan.walls.is_empty() && plan.corridors.is_empty() {
        return Err(found_nothing(NO_WALLS, notes));
    }
    Ok(Import { plan, notes: notes.into_vec() })
}

/// Refuses what is drawn in a wrong unit, before all of it is taken for rests of rounding.
fn refuse_tiny<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Result<(), String> {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let [x, y] = points.fold([none; 2], |range, point| {
        [0, 1].map(|axis: usize| [range[axis][0].min(point[axis]), range[axis][1].max(point[axis])])
    });
    let (width_m, height_m) = (x[1] - x[0], y[1] - y[0]);
    // Where nothing is drawn, both are below zero.
    if width_m.max(height_m) >= MIN_BUILDING_M || width_m < 0.0 {
        return Ok(());
    }
    Err(format!(
        "expected a building of at least {MIN_BUILDING_M} m, found a drawing of {:.1} x {:.1} mm; is its unit right?",
        1e3 * width_m,
        1e3 * height_m
    ))
}

/// Whether a place is farther from the origin than any building, or nowhere.
pub(super) fn is_far(x: f64, y: f64) -> bool {
    !(x.abs() <= MAX_COORDINATE_M && y.abs() <= MAX_COORDINATE_M)
}

/// Adds the points of a curve after its first one, which is there already.
pub(super) fn push_curve(points: &mut Vec<[f64; 2]>, curves: &mut Vec<[usize; 2]>, curve: &[[f64; 2]]) {
    let (Some(first), Some(end)) = (points.len().checked_sub(1), curve.last()) else { return };
    for point in &curve[..curve.len() - 1] {
        let is_far = |other: &[f64; 2]| distance_m(point, other) >= 1.2 * MIN_WALL_M;
        if is_far(&points[points.len() - 1]) && is_far(end) {
            points.push(*point);
        }
    }
    points.push(*end);
    curves.push([first, points.len() - 1]);
}

/// An outline's corners without those that are too near to the one before.
fn without_short_sides(outline: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::with_capacity(outline.len());
    for corner in outline {
        if kept.last().is_none_or(|last| distance_m(last, corner) >= MIN_WALL_M) {
            kept.push(*corner);
        }
    }
    while kept.len() > 1 && distance_m(&kept[0], &kept[kept.len() - 1]) < MIN_WALL_M {
        kept.pop();
    }
    kept
}

/// The sides of an outline.
pub(super) fn sides(outline: &[[f64; 2]]) -> impl Iterator<Item = Piece> {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(from, to)| [*from, *to])
}

/// To a tenth of a millimeter: units of drawings are turned into meters with an error in the last digits. No negative zero.
pub(super) fn rounded(value_m: f64) -> f64 {
    (value_m * 1e4).round() / 1e4 + 0.0
}

pub(super) fn distance_m(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
