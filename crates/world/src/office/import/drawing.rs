//! From the strokes of a drawing to a plan: which stroke is a wall, a corridor or a door.

use crate::office::{CorridorPlan, DoorPlan, OfficePlan, SurfaceColor, WallPlan, WallSides};

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

/// Straight lines from point to point, meters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stroke {
    pub role: Role,
    pub points: Vec<[f64; 2]>,
    pub is_closed: bool,
}

/// Names say what a stroke is; the first that says something counts. Layers of architects' drawings are called `A-WALL` or
/// `A-DOOR`, so a part of the name suffices.
pub(super) fn role_by_name<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<Role> {
    names.into_iter().find_map(|name| {
        let name = name.to_ascii_lowercase();
        if name.contains("door") {
            Some(Role::Door { color: None, is_open: name.contains("open") })
        } else if name.contains("corridor") || name.contains("floor") {
            Some(Role::Corridor)
        } else {
            name.contains("wall").then_some(Role::Wall)
        }
    })
}

/// A door's edges so near to the ends of walls fill the gap between them, meters.
const GAP_M: f64 = 0.05;
/// Shorter pieces of walls are left out: rests of rounding, meters.
const MIN_WALL_M: f64 = 0.05;

/// The plan of all strokes. Where a wall is interrupted by a door, the wall goes on behind it.
pub(super) fn plan_of(title: &str, strokes: &[Stroke]) -> OfficePlan {
    let mut plan = OfficePlan::named(title);
    for stroke in strokes {
        let points: Vec<[f64; 2]> = stroke.points.iter().map(|point| point.map(rounded)).collect();
        match stroke.role {
            Role::Corridor => plan.corridors.push(CorridorPlan { outline: points }),
            Role::Wall => {
                let closing = stroke.is_closed.then(|| [points[points.len() - 1], points[0]]);
                let pieces = points.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing);
                let long = pieces.filter(|[from, to]| distance_m(from, to) >= MIN_WALL_M);
                plan.walls.extend(long.map(|[from, to]| WallPlan { from, to, sides: WallSides::Both }));
            }
            Role::Door { color, is_open } => {
                let [from, to] = farthest(&points);
                let empty = DoorPlan { from, to, height_m: 2.05, color: SurfaceColor::RED, is_open };
                plan.doors.push(DoorPlan { color: color.unwrap_or(empty.color), ..empty });
            }
        }
    }
    let is_end = |at: &[f64; 2]| {
        let ends = plan.walls.iter().flat_map(|wall| [wall.from, wall.to]);
        ends.chain(plan.corridors.iter().flat_map(|corridor| corridor.outline.iter().copied()))
            .any(|end| distance_m(&end, at) < GAP_M)
    };
    let is_wall = |door: &DoorPlan| {
        plan.walls.iter().any(|wall| {
            let off = |end: &[f64; 2]| distance_from_line_m(wall, end);
            off(&door.from) < GAP_M && off(&door.to) < GAP_M
        })
    };
    let in_gap = |door: &&DoorPlan| is_end(&door.from) && is_end(&door.to) && !is_wall(door);
    let fills: Vec<WallPlan> = plan
        .doors
        .iter()
        .filter(in_gap)
        .map(|door| WallPlan { from: door.from, to: door.to, sides: WallSides::Both })
        .collect();
    plan.walls.extend(fills);
    plan
}

/// To a tenth of a millimeter: units of drawings are turned into meters with an error in the last digits. No negative zero.
fn rounded(value_m: f64) -> f64 {
    (value_m * 1e4).round() / 1e4 + 0.0
}

fn distance_m(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance of a point from a wall, ends included.
fn distance_from_line_m(wall: &WallPlan, at: &[f64; 2]) -> f64 {
    let [along_x, along_y] = [wall.to[0] - wall.from[0], wall.to[1] - wall.from[1]];
    let [x, y] = [at[0] - wall.from[0], at[1] - wall.from[1]];
    let length2 = along_x * along_x + along_y * along_y;
    let t = if length2 > 0.0 { ((x * along_x + y * along_y) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (x - t * along_x).hypot(y - t * along_y)
}

/// The two points of a door that are farthest apart: a door may be drawn as a leaf with its thickness.
fn farthest(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let mut best = [points[0], points[0]];
    for (i, a) in points.iter().enumerate() {
        for b in &points[i + 1..] {
            if distance_m(a, b) > distance_m(&best[0], &best[1]) {
                best = [*a, *b];
            }
        }
    }
    best
}
