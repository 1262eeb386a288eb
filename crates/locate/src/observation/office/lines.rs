//! The theoretical lines of a building: edges of doors, corners that hide a part of a door, and where walls and doors meet
//! the floor.

use nalgebra::{Point2, Vector2};
use visloc_world::office::{Door, Office, Wall};

use crate::vision::{DoorSide, FeatureKind};

/// A piece of a border that the image analysis can find: straight, in one wall, seen from one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TheoreticalLine {
    pub kind: FeatureKind,
    /// Lower or left end, (x, y) of the world, meters.
    pub start: Point2<f64>,
    /// Upper or right end; the same place for an upright line.
    pub end: Point2<f64>,
    /// Height of the second end, meters; the first one is on the floor.
    pub end_height_m: f64,
    /// Unit vector to those who can see it.
    pub normal: Vector2<f64>,
}

/// Longer borders of the floor are cut: of a piece that is hidden in its middle only one side is seen, meters.
const MAX_PIECE_M: f64 = 3.0;
/// How far from a corner it is seen that the floor goes on around it, meters.
const CORNER_M: f64 = 0.25;
/// Shorter pieces are of no use, meters.
const MIN_PIECE_M: f64 = 0.02;

impl TheoreticalLine {
    /// A part of a border of the floor, from one share of its length to another.
    #[inline]
    pub fn part(&self, [from, to]: [f64; 2]) -> Self {
        let at = |share: f64| self.start + (self.end - self.start) * share;
        Self { start: at(from), end: at(to), ..*self }
    }
}

/// All theoretical lines of a building.
pub(super) fn theoretical_lines(office: &Office) -> Vec<TheoreticalLine> {
    let mut lines = Vec::new();
    for (i, wall) in office.walls().iter().enumerate() {
        let (along, normal) = (wall.direction(), wall.normal());
        let mut doors: Vec<&Door> = office.doors().iter().filter(|door| door.wall == i).collect();
        let place = |point: &Point2<f64>| (point - wall.start).dot(&along);
        doors.sort_by(|a, b| place(&a.left).total_cmp(&place(&b.left)));
        let mut wall_from = wall.start;
        for door in doors {
            add_foot(&mut lines, FeatureKind::WallFoot, wall_from, door.left, normal);
            wall_from = door.right;
            if door.is_open {
                continue;
            }
            add_foot(&mut lines, FeatureKind::DoorFoot, door.left, door.right, normal);
            for (side, at) in [(DoorSide::Left, door.left), (DoorSide::Right, door.right)] {
                if has_wall_beside(office, i, wall, door, side) {
                    lines.push(TheoreticalLine {
                        kind: FeatureKind::DoorEdge { side, paint: door.paint },
                        start: at,
                        end: at,
                        end_height_m: door.height_m,
                        normal,
                    });
                }
            }
        }
        add_foot(&mut lines, FeatureKind::WallFoot, wall_from, wall.end, normal);
        add_corners(&mut lines, office, wall);
    }
    lines
}

/// Where a wall ends and the room goes on behind its end, a door behind it seems to begin. What is seen at the right of a
/// wall is like the left edge of a door.
fn add_corners(lines: &mut Vec<TheoreticalLine>, office: &Office, wall: &Wall) {
    let along = wall.direction();
    for (side, at, outward) in [(DoorSide::Left, wall.end, along), (DoorSide::Right, wall.start, -along)] {
        // Beside a convex corner there is floor beyond the wall's end, on both sides of its line.
        let beyond = at + outward * CORNER_M;
        let is_free = |point: Point2<f64>| office.free_space().contains(point.x, point.y);
        if !(is_free(beyond + wall.normal() * CORNER_M) && is_free(beyond - wall.normal() * CORNER_M)) {
            continue;
        }
        for paint in (0..=u8::MAX).take(office.door_colors().len()) {
            lines.push(TheoreticalLine {
                kind: FeatureKind::DoorEdge { side, paint },
                start: at,
                end: at,
                end_height_m: office.plan().ceiling_height_m,
                normal: wall.normal(),
            });
        }
    }
}

/// A door's edge is seen where a wall is beside it: not where another door begins.
fn has_wall_beside(office: &Office, wall_index: usize, wall: &Wall, door: &Door, side: DoorSide) -> bool {
    let along = wall.direction();
    let at = match side {
        DoorSide::Left => door.left,
        DoorSide::Right => door.right,
    };
    office.doors().iter().filter(|other| other.wall == wall_index && *other != door).all(|other| {
        let neighbor = match side {
            DoorSide::Left => other.right,
            DoorSide::Right => other.left,
        };
        (neighbor - at).dot(&along).abs() > MIN_PIECE_M
    })
}

fn add_foot(
    lines: &mut Vec<TheoreticalLine>,
    kind: FeatureKind,
    from: Point2<f64>,
    to: Point2<f64>,
    normal: Vector2<f64>,
) {
    let length_m = (to - from).norm();
    if length_m < MIN_PIECE_M {
        return;
    }
    let count = (length_m / MAX_PIECE_M).ceil().max(1.0);
    let mut i = 0.0;
    while i < count {
        let at = |t: f64| from + (to - from) * (t / count);
        lines.push(TheoreticalLine { kind, start: at(i), end: at(i + 1.0), end_height_m: 0.0, normal });
        i += 1.0;
    }
}
