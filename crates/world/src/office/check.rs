//! What can be wrong with a plan.

#[cfg(feature = "import")]
use super::{CorridorPlan, geometry::walls_of};
use super::{
    OfficePlan, Wall,
    geometry::{ON_WALL_M, point},
    plan::OFFICE,
};
use crate::{MapError, error::WHICH_UNIT};

/// Shorter walls and doors are mistakes, meters.
pub(crate) const MIN_LENGTH_M: f64 = 0.05;
/// Walls that lie on each other for less than this only touch, meters.
pub(crate) const TOUCH_M: f64 = 0.02;
/// Sides of outlines that reach farther than this to both sides of each other cross, meters. Less may be what is left of
/// a grid's cells.
const CROSSING_M: f64 = 0.15;
/// No building is farther from the origin, meters.
pub(crate) const MAX_COORDINATE_M: f64 = 10_000.0;
/// No building is larger, the square around it: the floor is kept in cells, square meters.
const MAX_AREA_M2: f64 = 250_000.0;
/// More walls or doors are not compared with each other.
pub(crate) const MAX_WALLS: usize = 20_000;
pub(crate) const MAX_DOORS: usize = 5_000;

/// Checks what a plan says before anything is made of it: numbers, counts and sizes.
pub(super) fn check_sizes(name: &str, plan: &OfficePlan) -> Result<(), MapError> {
    let check = Check { name };
    if plan.kind != OFFICE {
        return check.fail("kind", "\"office\", a building", format!("{:?}", plan.kind));
    }
    check.counts(plan)?;
    check.sizes(plan)?;
    check.area(plan)
}

/// Checks a plan with its walls, after [`check_sizes`].
pub(super) fn check_plan(name: &str, plan: &OfficePlan, walls: &[Wall]) -> Result<(), MapError> {
    let check = Check { name };
    if walls.is_empty() {
        return check.fail("corridors, walls", "at least one wall", "none".to_owned());
    }
    check.walls(walls)?;
    check.doors(plan, walls)?;
    check.colors(plan)
}

struct Check<'a> {
    name: &'a str,
}

impl Check<'_> {
    fn fail(&self, key: &str, expected: &'static str, found: String) -> Result<(), MapError> {
        Err(MapError::Value { name: self.name.to_owned(), key: key.to_owned(), expected, found })
    }

    fn counts(&self, plan: &OfficePlan) -> Result<(), MapError> {
        let num_sides: usize = plan.corridors.iter().map(|corridor| corridor.outline.len()).sum();
        let num_walls = num_sides + plan.walls.len();
        if num_walls > MAX_WALLS {
            let expected = "at most 20000 sides and walls; leave out furniture and other details";
            return self.fail("corridors, walls", expected, num_walls.to_string());
        }
        if plan.doors.len() > MAX_DOORS {
            return self.fail("doors", "at most 5000 doors", plan.doors.len().to_string());
        }
        Ok(())
    }

    /// Whether the floor is small enough to be kept in cells.
    fn area(&self, plan: &OfficePlan) -> Result<(), MapError> {
        let corners = || {
            let outlines = plan.corridors.iter().flat_map(|corridor| &corridor.outline);
            outlines.chain(plan.walls.iter().flat_map(|wall| [&wall.from, &wall.to])).copied().map(point)
        };
        let Some(first) = corners().next() else { return Ok(()) };
        let size = corners().fold(first, |max, p| max.sup(&p)) - corners().fold(first, |min, p| min.inf(&p));
        if size.x * size.y <= MAX_AREA_M2 {
            return Ok(());
        }
        let expected = "a building on at most 250000 square meters, in meters";
        self.fail("corridors, walls", expected, format!("{:.0} x {:.0} m; {WHICH_UNIT}", size.x, size.y))
    }

    fn sizes(&self, plan: &OfficePlan) -> Result<(), MapError> {
        let height_m = plan.ceiling_height_m;
        if !(height_m > 0.5 && height_m < 100.0) {
            return self.fail("ceiling_height_m", "0.5 to 100 m", height_m.to_string());
        }
        for (i, corridor) in plan.corridors.iter().enumerate() {
            if corridor.outline.len() < 3 {
                let found = format!("{} corners", corridor.outline.len());
                return self.fail(&format!("corridors[{i}].outline"), "at least 3 corners", found);
            }
            if let Some(side) = corridor.open_sides.iter().find(|side| **side >= corridor.outline.len()) {
                let key = format!("corridors[{i}].open_sides");
                return self.fail(&key, "numbers of sides, counted from 0", side.to_string());
            }
            for corner in &corridor.outline {
                self.position(&format!("corridors[{i}].outline"), corner)?;
            }
        }
        for (i, wall) in plan.walls.iter().enumerate() {
            self.position(&format!("walls[{i}].from"), &wall.from)?;
            self.position(&format!("walls[{i}].to"), &wall.to)?;
        }
        for (i, door) in plan.doors.iter().enumerate() {
            self.position(&format!("doors[{i}].from"), &door.from)?;
            self.position(&format!("doors[{i}].to"), &door.to)?;
            if !(door.height_m > 0.5 && door.height_m <= height_m) {
                let expected = "above 0.5 m and at most ceiling_height_m";
                return self.fail(&format!("doors[{i}].height_m"), expected, door.height_m.to_string());
            }
        }
        Ok(())
    }

    fn position(&self, key: &str, xy: &[f64; 2]) -> Result<(), MapError> {
        if xy.iter().all(|value| value.abs() <= MAX_COORDINATE_M) {
            return Ok(());
        }
        self.fail(key, "coordinates in meters, at most 10000 m", format!("[{}, {}]", xy[0], xy[1]))
    }

    fn walls(&self, walls: &[Wall]) -> Result<(), MapError> {
        for wall in walls {
            let length_m = (wall.end - wall.start).norm();
            if length_m < MIN_LENGTH_M {
                return self.fail(&wall.origin, "a length of at least 0.05 m", format!("{length_m:.3} m"));
            }
        }
        let Some((wall, other, conflict)) = conflicts(walls).next() else { return Ok(()) };
        let (wall, other) = (&walls[wall], &walls[other]);
        match conflict {
            Conflict::Overlap { length_m } => {
                let (first, second) = if wall.origin < other.origin { (wall, other) } else { (other, wall) };
                let found = format!("{length_m:.2} m of it on {}", second.origin);
                self.fail(&first.origin, "a wall that overlaps no other", found)
            }
            Conflict::Crossing => {
                let expected = "an outline that crosses neither itself nor another one";
                self.fail(&wall.origin, expected, format!("it crosses {}", other.origin))
            }
        }
    }

    fn doors(&self, plan: &OfficePlan, walls: &[Wall]) -> Result<(), MapError> {
        let mut taken: Vec<(usize, f64, f64, usize)> = Vec::new();
        for (i, door) in plan.doors.iter().enumerate() {
            let (key, ends) = (format!("doors[{i}]"), [point(door.from), point(door.to)]);
            let width_m = (ends[1] - ends[0]).norm();
            if width_m < MIN_LENGTH_M {
                return self.fail(&key, "a width of at least 0.05 m", format!("{width_m:.3} m"));
            }
            let Some(at) = walls.iter().position(|wall| wall.holds(&ends)) else {
                let found = format!(
                    "({}, {}) to ({}, {}), {}",
                    door.from[0],
                    door.from[1],
                    door.to[0],
                    door.to[1],
                    off_nearest(walls, &ends)
                );
                return self.fail(&key, "both edges on one wall", found);
            };
            let wall = &walls[at];
            let [a, b] = ends.map(|end| (end - wall.start).dot(&wall.direction()));
            let (from, to) = (a.min(b), a.max(b));
            let under = taken.iter().find(|(w, f, t, _)| *w == at && from < t - TOUCH_M && to > f + TOUCH_M);
            if let Some((_, _, _, other)) = under {
                return self.fail(
                    &key,
                    "a door that overlaps no other",
                    format!("doors[{other}] in its place"),
                );
            }
            taken.push((at, from, to, i));
        }
        Ok(())
    }

    fn colors(&self, plan: &OfficePlan) -> Result<(), MapError> {
        if !plan.floor_color.differs_from(&plan.wall_color) {
            let found = format!("{} walls and {} floor", plan.wall_color, plan.floor_color);
            return self.fail("floor_color", "a color that a camera can tell from wall_color", found);
        }
        for (i, door) in plan.doors.iter().enumerate().filter(|(_, door)| !door.is_open) {
            if !door.color.differs_from(&plan.wall_color) {
                let found = format!("{} on {} walls", door.color, plan.wall_color);
                let expected = "a color that a camera can tell from wall_color";
                return self.fail(&format!("doors[{i}].color"), expected, found);
            }
        }
        Ok(())
    }
}

/// What two walls of a plan may not do.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Conflict {
    /// They lie on each other for this long.
    Overlap { length_m: f64 },
    /// Two sides of outlines cross.
    Crossing,
}

/// Pairs of walls that overlap or cross, as indices.
fn conflicts(walls: &[Wall]) -> impl Iterator<Item = (usize, usize, Conflict)> {
    // Sorted by their least x, so that walls far from each other are never compared.
    let min_x = |i: usize| walls[i].start.x.min(walls[i].end.x);
    let max_x = |i: usize| walls[i].start.x.max(walls[i].end.x);
    let is_beside = |a: &Wall, b: &Wall| {
        b.start.y.min(b.end.y) <= a.start.y.max(a.end.y) + ON_WALL_M
            && a.start.y.min(a.end.y) <= b.start.y.max(b.end.y) + ON_WALL_M
    };
    let mut order: Vec<usize> = (0..walls.len()).collect();
    order.sort_by(|a, b| min_x(*a).total_cmp(&min_x(*b)));
    (0..order.len()).flat_map(move |at| {
        let first = order[at];
        let end = max_x(first) + ON_WALL_M;
        let near = order[at + 1..].iter().copied().take_while(|second| min_x(*second) <= end);
        let found = near.filter_map(|second| {
            let (wall, other) = (&walls[first], &walls[second]);
            if !is_beside(wall, other) || wall.origin == other.origin {
                return None;
            }
            let length_m = overlap_m(wall, other);
            if length_m > TOUCH_M {
                return Some((first, second, Conflict::Overlap { length_m }));
            }
            let is_crossed = is_side(wall) && is_side(other) && is_crossing(wall, other);
            is_crossed.then_some((first, second, Conflict::Crossing))
        });
        found.collect::<Vec<_>>()
    })
}

/// Opens the shorter one of two sides of outlines that overlap or cross, and says how many: where a plan comes from cells, strips narrower
/// than what its outlines are straightened by become such pairs.
#[cfg(feature = "import")]
pub(crate) fn open_conflicting_sides(plan: &mut OfficePlan) -> usize {
    if (Check { name: "" }).counts(plan).is_err() {
        return 0;
    }
    // In the order of the walls that come of them.
    let sides: Vec<(usize, usize)> = plan.corridors.iter().enumerate().flat_map(walled_sides).collect();
    let walls = walls_of(plan);
    let length_m = |i: usize| (walls[i].end - walls[i].start).norm();
    let mut is_open = vec![false; sides.len()];
    for (a, b, _) in conflicts(&walls).filter(|(a, b, _)| a.max(b) < &sides.len()) {
        if !is_open[a] && !is_open[b] {
            is_open[if length_m(a) < length_m(b) { a } else { b }] = true;
        }
    }
    for ((corridor, side), _) in sides.iter().zip(&is_open).filter(|(_, is_open)| **is_open) {
        plan.corridors[*corridor].open_sides.push(*side);
    }
    plan.corridors.iter_mut().for_each(|corridor| corridor.open_sides.sort_unstable());
    is_open.iter().filter(|is_open| **is_open).count()
}

/// The sides of an outline that are walls, each with the corridor's number.
#[cfg(feature = "import")]
fn walled_sides((i, corridor): (usize, &CorridorPlan)) -> Vec<(usize, usize)> {
    let sides = 0..corridor.outline.len();
    sides.filter(|side| !corridor.open_sides.contains(side)).map(|side| (i, side)).collect()
}

/// Length for which two walls lie on each other, meters.
pub(super) fn overlap_m(wall: &Wall, other: &Wall) -> f64 {
    let along = wall.direction();
    let offsets = [other.start, other.end].map(|end| end - wall.start);
    if offsets.iter().any(|offset| offset.perp(&along).abs() > TOUCH_M) {
        return 0.0;
    }
    let [a, b] = offsets.map(|offset| offset.dot(&along));
    a.max(b).min((wall.end - wall.start).norm()) - a.min(b).max(0.0)
}

/// Whether a wall is a side of a corridor's outline.
fn is_side(wall: &Wall) -> bool {
    wall.origin.starts_with("corridors")
}

/// Whether each of two walls has its ends well on both sides of the other one.
fn is_crossing(wall: &Wall, other: &Wall) -> bool {
    let parts = |line: &Wall, ends: &Wall| {
        let [a, b] = [ends.start, ends.end].map(|end| line.direction().perp(&(end - line.start)));
        a.min(b) < -CROSSING_M && a.max(b) > CROSSING_M
    };
    parts(wall, other) && parts(other, wall)
}

/// How far the farther edge of a door is off the wall that is nearest to both edges.
fn off_nearest(walls: &[Wall], ends: &[nalgebra::Point2<f64>; 2]) -> String {
    let off_m = |wall: &Wall| ends.iter().fold(0.0_f64, |farthest, end| farthest.max(wall.distance_m(end)));
    let with_distance = walls.iter().map(|wall| (wall, off_m(wall)));
    let Some((nearest, off_m)) = with_distance.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return "without any wall".to_owned();
    };
    let beside_m = |end: &nalgebra::Point2<f64>| nearest.direction().perp(&(end - nearest.start)).abs();
    if ends.iter().all(|end| beside_m(end) <= ON_WALL_M) {
        return format!("{off_m:.2} m beyond the end of {}", nearest.origin);
    }
    format!("{off_m:.2} m off the nearest wall, {}", nearest.origin)
}
