//! The building as geometry: one-sided walls and doors.

use nalgebra::{Point2, Vector2};

use super::{
    FreeSpace, OfficePlan, SurfaceColor, WallSides,
    check::{check_plan, check_sizes},
};
use crate::{MapError, error::syntax_error};

/// A wall seen from one side: it is seen by those who stand to the right of the way from `start` to `end`, for whom
/// `start` is at the left. Meters.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Its left end.
    pub start: Point2<f64>,
    /// Its right end.
    pub end: Point2<f64>,
    /// Where it comes from in the file, for errors.
    pub origin: String,
}

/// A door seen from one side, `left` at the left. Meters.
#[derive(Debug, Clone, PartialEq)]
pub struct Door {
    /// Index of its wall.
    pub wall: usize,
    /// Its left edge.
    pub left: Point2<f64>,
    /// Its right edge.
    pub right: Point2<f64>,
    /// From the floor to its upper edge.
    pub height_m: f64,
    /// Index of its color in [`Office::door_colors`].
    pub paint: u8,
    /// Whether it stands open.
    pub is_open: bool,
}

/// A building from inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Office {
    plan: OfficePlan,
    walls: Vec<Wall>,
    doors: Vec<Door>,
    door_colors: Vec<SurfaceColor>,
    free_space: FreeSpace,
}

/// A door's edge may be so far from its wall, meters.
pub(super) const ON_WALL_M: f64 = 0.05;

impl Office {
    /// Reads and checks the text of a map file.
    pub(crate) fn parse(name: &str, text: &str) -> Result<Self, MapError> {
        let plan: OfficePlan = toml::from_str(text).map_err(|error| syntax_error(name, text, &error))?;
        Self::new(name, plan)
    }

    /// The building of a plan; `name` is used in errors.
    ///
    /// # Errors
    /// If walls overlap or have no length, a door lies off any wall or over another one, or colors cannot be told
    /// apart. The error names the element.
    pub fn new(name: &str, plan: OfficePlan) -> Result<Self, MapError> {
        check_sizes(name, &plan)?;
        let walls = walls_of(&plan);
        check_plan(name, &plan, &walls)?;
        let mut door_colors = Vec::new();
        let mut doors = Vec::new();
        for door in &plan.doors {
            let known = door_colors.iter().position(|color| *color == door.color);
            let paint = known.unwrap_or_else(|| {
                door_colors.push(door.color);
                door_colors.len() - 1
            });
            let ends = [point(door.from), point(door.to)];
            for (wall, seen) in walls.iter().enumerate().filter(|(_, wall)| wall.holds(&ends)) {
                let [left, right] = seen.ordered(ends);
                doors.push(Door {
                    wall,
                    left,
                    right,
                    height_m: door.height_m,
                    paint: u8::try_from(paint).unwrap_or(u8::MAX),
                    is_open: door.is_open,
                });
            }
        }
        let free_space = FreeSpace::new(&plan, &walls);
        Ok(Self { plan, walls, doors, door_colors, free_space })
    }

    /// What the file says.
    pub fn plan(&self) -> &OfficePlan {
        &self.plan
    }

    /// All walls, one for each side that is seen.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// All doors, one for each side that is seen.
    pub fn doors(&self) -> &[Door] {
        &self.doors
    }

    /// The different colors of the doors.
    pub fn door_colors(&self) -> &[SurfaceColor] {
        &self.door_colors
    }

    /// Where a robot can be.
    pub fn free_space(&self) -> &FreeSpace {
        &self.free_space
    }

    /// Length of all walls, meters.
    pub fn wall_length_m(&self) -> f64 {
        self.walls.iter().map(|wall| (wall.end - wall.start).norm()).sum()
    }
}

impl Wall {
    /// Unit vector from its left to its right end.
    pub fn direction(&self) -> Vector2<f64> {
        (self.end - self.start).normalize()
    }

    /// Unit vector from the wall to those who see it.
    pub fn normal(&self) -> Vector2<f64> {
        let along = self.direction();
        Vector2::new(along.y, -along.x)
    }

    /// From its nearest point to a place, meters.
    pub fn distance_m(&self, at: &Point2<f64>) -> f64 {
        let along = self.end - self.start;
        let t = ((at - self.start).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (at - (self.start + along * t)).norm()
    }

    /// Whether it hides one point from the other: the straight way between them crosses it, more than `slack_m` from
    /// its ends.
    pub fn hides(&self, from: &Point2<f64>, to: &Point2<f64>, slack_m: f64) -> bool {
        let (wall, way) = (self.end - self.start, to - from);
        let across = way.perp(&wall);
        if across == 0.0 {
            return false;
        }
        let offset = self.start - from;
        let (along_way, along_wall) = (offset.perp(&wall) / across, offset.perp(&way) / across);
        let length_m = way.norm();
        along_way * length_m > slack_m
            && (1.0 - along_way) * length_m > slack_m
            && (0.0..=1.0).contains(&along_wall)
    }

    /// Whether both points lie on it.
    pub(super) fn holds(&self, points: &[Point2<f64>; 2]) -> bool {
        let (along, length_m) = (self.direction(), (self.end - self.start).norm());
        points.iter().all(|point| {
            let from_start = point - self.start;
            let s = from_start.dot(&along);
            from_start.perp(&along).abs() <= ON_WALL_M && s >= -ON_WALL_M && s <= length_m + ON_WALL_M
        })
    }

    /// Two points on it, the left one first, exactly on its line.
    fn ordered(&self, points: [Point2<f64>; 2]) -> [Point2<f64>; 2] {
        let along = self.direction();
        let [a, b] = points.map(|point| (point - self.start).dot(&along));
        [a.min(b), a.max(b)].map(|s| self.start + along * s)
    }
}

pub(super) fn point(xy: [f64; 2]) -> Point2<f64> {
    Point2::new(xy[0], xy[1])
}

/// All walls of a plan, seen from their free side.
pub(super) fn walls_of(plan: &OfficePlan) -> Vec<Wall> {
    let mut walls = Vec::new();
    let extents: Vec<[Point2<f64>; 2]> = plan.corridors.iter().map(|c| extent(&c.outline)).collect();
    for (i, corridor) in plan.corridors.iter().enumerate() {
        let corners: Vec<_> = corridor.outline.iter().copied().map(point).collect();
        // An outline inside an odd number of others is a pillar or a courtyard: its floor is outside.
        let others = |corner: &Point2<f64>| {
            let near = (0..extents.len()).filter(|j| *j != i && is_within(&extents[*j], corner));
            near.filter(|j| is_inside(&plan.corridors[*j].outline, corner)).count()
        };
        let depth = corners.first().map_or(0, others);
        let is_floor_inside = depth % 2 == 0;
        // Going around clockwise, the inside is at the right.
        let is_as_written = (signed_area(&corners) < 0.0) == is_floor_inside;
        let mut has_wall = vec![true; corners.len()];
        for side in &corridor.open_sides {
            has_wall[*side] = false;
        }
        for (k, start) in corners.iter().enumerate().filter(|(k, _)| has_wall[*k]) {
            let end = corners[(k + 1) % corners.len()];
            let (start, end) = if is_as_written { (*start, end) } else { (end, *start) };
            walls.push(Wall { start, end, origin: format!("corridors[{i}] side {k}") });
        }
    }
    for (i, wall) in plan.walls.iter().enumerate() {
        let (start, end, origin) = (point(wall.from), point(wall.to), format!("walls[{i}]"));
        if wall.sides == WallSides::Both {
            walls.push(Wall { start: end, end: start, origin: origin.clone() });
        }
        walls.push(Wall { start, end, origin });
    }
    walls
}

/// Least and largest coordinates of corners.
fn extent(corners: &[[f64; 2]]) -> [Point2<f64>; 2] {
    let [none, all] = [f64::MAX, f64::MIN].map(|value| Point2::new(value, value));
    corners.iter().fold([none, all], |[min, max], xy| [min.inf(&point(*xy)), max.sup(&point(*xy))])
}

fn is_within([min, max]: &[Point2<f64>; 2], at: &Point2<f64>) -> bool {
    *min <= *at && *at <= *max
}

/// Twice the area that corners enclose, positive if they go around counterclockwise.
fn signed_area(corners: &[Point2<f64>]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.coords.perp(&b.coords)).sum()
}

/// Whether a point lies inside an outline.
pub(super) fn is_inside(outline: &[[f64; 2]], at: &Point2<f64>) -> bool {
    let next = outline.iter().cycle().skip(1);
    let crosses = |(a, b): &(&[f64; 2], &[f64; 2])| {
        (a[1] > at.y) != (b[1] > at.y) && at.x < a[0] + (at.y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    outline.iter().zip(next).filter(crosses).count() % 2 == 1
}
