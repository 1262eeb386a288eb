//! What hinders a robot from finding out where it is, as far as the map alone can tell.

use std::fmt;

use nalgebra::{Point2, Vector2};
use serde::Serialize;
use visloc_core::median;

use crate::{
    Map,
    error::WHICH_UNIT,
    field::Field,
    office::{Office, Wall},
};

/// Something about a map that keeps a robot from being found, or that makes it probable that the map is wrong.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Hindrance {
    /// No door that could be seen.
    NoDoors {
        /// Whether there are doors that always stand open.
        has_open_doors: bool,
    },
    /// There is no place for a robot.
    NoFloor,
    /// Walls enclose nothing, so that everything between them counts as floor.
    WallsNotClosed {
        /// Ends of walls at which no other wall goes on, at most eight; (x, y) in meters.
        loose_ends_m: Vec<[f64; 2]>,
    },
    /// No robot comes from one part of the floor to another.
    FloorInParts {
        /// Their areas, the largest first.
        areas_m2: Vec<f64>,
    },
    /// The map looks the same after a turn.
    Symmetric {
        /// Poses that cannot be told from each other.
        num_poses: usize,
    },
    /// The floor is larger or smaller than any that makes sense, as in another unit.
    StrangeSize {
        /// Along x and y.
        size_m: [f64; 2],
    },
    /// Half of the doors or more are narrower or wider than doors are, as in another unit.
    StrangeDoors {
        /// The width in the middle of all widths.
        median_width_m: f64,
    },
}

impl fmt::Display for Hindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDoors { has_open_doors } => {
                let doors = if *has_open_doors { "no door that can be closed" } else { "no doors" };
                write!(
                    f,
                    "{doors}: walls alone look alike nearly everywhere, so the robot will hardly be found; add [[doors]]"
                )
            }
            Self::NoFloor => {
                write!(f, "no floor: nowhere is a robot 0.1 m or more off the walls; {WHICH_UNIT}")
            }
            Self::WallsNotClosed { loose_ends_m } => {
                f.write_str("the walls enclose nothing, so everything between them counts as floor; ")?;
                let ends: Vec<String> =
                    loose_ends_m.iter().map(|[x, y]| format!("({x:.2}, {y:.2})")).collect();
                match ends.is_empty() {
                    true => f.write_str("close them, or draw the floor as a corridor"),
                    false => write!(f, "they end freely at {}", ends.join(", ")),
                }
            }
            Self::FloorInParts { areas_m2 } => {
                const MAX_SHOWN: usize = 6;
                let mut areas: Vec<String> =
                    areas_m2.iter().take(MAX_SHOWN).map(|a| format!("{a:.1}")).collect();
                if areas_m2.len() > MAX_SHOWN {
                    areas.push("...".to_owned());
                }
                let num = areas_m2.len();
                write!(
                    f,
                    "the floor has {num} parts without a way between them ({} m2); ",
                    areas.join(", ")
                )?;
                f.write_str("the robot is looked for in all of them")
            }
            Self::Symmetric { num_poses } => write!(
                f,
                "it looks the same from {num_poses} poses, turned about its middle; the camera alone cannot tell one from the \
                 other"
            ),
            Self::StrangeSize { size_m: [x, y] } => {
                write!(f, "it is {x:.2} x {y:.2} m large; {WHICH_UNIT}")
            }
            Self::StrangeDoors { median_width_m } => {
                write!(f, "doors are {median_width_m:.2} m wide; {WHICH_UNIT}")
            }
        }
    }
}

impl Map {
    /// What hinders a robot from finding out where it is, as far as the map alone can tell; empty if nothing does.
    pub fn what_hinders_localization(&self) -> Vec<Hindrance> {
        match self {
            Self::Field(field) => of_field(field),
            Self::Office(office) => of_office(office),
        }
    }
}

fn of_field(field: &Field) -> Vec<Hindrance> {
    let dimensions = field.dimensions();
    let is_strange = !(FIELDS_M[0]..=FIELDS_M[1]).contains(&dimensions.length_m);
    let size = Hindrance::StrangeSize { size_m: [dimensions.length_m, dimensions.width_m] };
    let symmetric = Hindrance::Symmetric { num_poses: 2 };
    let found = [is_strange.then_some(size), field.is_point_symmetric().then_some(symmetric)];
    found.into_iter().flatten().collect()
}

/// A field is at least so long (a table with small robots) and at most so long (the Laws of the Game, law 1), meters.
const FIELDS_M: [f64; 2] = [1.0, 120.0];

/// A building is at least so long and at most so long, meters.
const SIZES_M: [f64; 2] = [1.5, 1000.0];
/// A door is so wide, meters.
const DOORS_M: [f64; 2] = [0.4, 6.0];
/// Smaller parts of the floor are niches behind something, square meters.
const MIN_PART_M2: f64 = 0.5;

fn of_office(office: &Office) -> Vec<Hindrance> {
    let (plan, space) = (office.plan(), office.free_space());
    let mut found = Vec::new();
    let [min, max] = space.bounds_m();
    let size_m = [max.x - min.x, max.y - min.y];
    let longest_m = size_m[0].max(size_m[1]);
    if !(SIZES_M[0]..=SIZES_M[1]).contains(&longest_m) {
        found.push(Hindrance::StrangeSize { size_m });
    }
    if plan.doors.iter().all(|door| door.is_open) {
        found.push(Hindrance::NoDoors { has_open_doors: !plan.doors.is_empty() });
    }
    if let Some(median_width_m) = median(office.doors().iter().map(|door| (door.right - door.left).norm()))
        && !(DOORS_M[0]..=DOORS_M[1]).contains(&median_width_m)
    {
        found.push(Hindrance::StrangeDoors { median_width_m });
    }
    if space.area_m2() == 0.0 {
        found.push(Hindrance::NoFloor);
        return found;
    }
    if !space.is_enclosed() {
        found.push(Hindrance::WallsNotClosed { loose_ends_m: loose_ends(office) });
    }
    let mut areas_m2 = space.parts_m2(&passages(office));
    areas_m2.retain(|area| *area >= MIN_PART_M2);
    if areas_m2.len() > 1 {
        found.push(Hindrance::FloorInParts { areas_m2 });
    }
    let num_poses = num_alike(office);
    if num_poses > 1 {
        found.push(Hindrance::Symmetric { num_poses });
    }
    found
}

/// Places in front of each door and behind it.
fn passages(office: &Office) -> Vec<[Point2<f64>; 2]> {
    /// From a face of a wall to the other one, and a robot's clearance, meters.
    const BEHIND_M: [f64; 4] = [0.2, 0.35, 0.5, 0.7];
    let both = |door: &crate::office::Door| {
        let normal = office.walls()[door.wall].normal();
        let middle = nalgebra::center(&door.left, &door.right);
        BEHIND_M.map(|behind_m| [middle + normal * BEHIND_M[0], middle - normal * behind_m])
    };
    office.doors().iter().flat_map(both).collect()
}

/// Ends of walls at which no other wall goes on.
fn loose_ends(office: &Office) -> Vec<[f64; 2]> {
    const NEAR_M: f64 = 0.15;
    const MAX_SHOWN: usize = 8;
    let is_loose = |i: usize, at: &Point2<f64>| {
        let own = &office.walls()[i].origin;
        !office.walls().iter().any(|wall| wall.origin != *own && wall.distance_m(at) < NEAR_M)
    };
    let mut ends: Vec<[f64; 2]> = Vec::new();
    for (i, wall) in office.walls().iter().enumerate() {
        for at in [wall.start, wall.end] {
            let is_new = !ends.iter().any(|end| (end[0] - at.x).hypot(end[1] - at.y) < NEAR_M);
            if is_new && is_loose(i, &at) {
                ends.push([at.x, at.y]);
            }
            if ends.len() == MAX_SHOWN {
                return ends;
            }
        }
    }
    ends
}

/// How many turns about the middle of the walls bring every wall and every door to where there is an equal one.
fn num_alike(office: &Office) -> usize {
    /// Larger buildings are compared by their first walls and doors only.
    const MAX_COMPARED: usize = 2_000;
    let total_m = office.wall_length_m();
    let middle = office.walls().iter().fold(Vector2::zeros(), |sum, wall| {
        sum + nalgebra::center(&wall.start, &wall.end).coords * ((wall.end - wall.start).norm() / total_m)
    });
    let turned = |at: &Point2<f64>, quarters: usize| {
        (0..quarters).fold(at - middle, |p, _| Point2::new(-p.y, p.x)) + middle
    };
    let is_near = |a: &Point2<f64>, b: &Point2<f64>| (a - b).norm() < 0.1;
    let is_alike = |quarters: &usize| {
        let door_there = |door: &crate::office::Door| {
            let (left, right) = (turned(&door.left, *quarters), turned(&door.right, *quarters));
            let is_same = |other: &crate::office::Door| {
                (other.paint, other.is_open) == (door.paint, door.is_open)
                    && is_near(&other.left, &left)
                    && is_near(&other.right, &right)
            };
            office.doors().iter().any(is_same)
        };
        let wall_there = |wall: &Wall| {
            let (start, end) = (turned(&wall.start, *quarters), turned(&wall.end, *quarters));
            let places = [start, nalgebra::center(&start, &end), end];
            let is_on =
                |place: &Point2<f64>| office.walls().iter().any(|other| other.distance_m(place) < 0.1);
            places.iter().all(is_on)
        };
        office.doors().iter().take(MAX_COMPARED).all(door_there)
            && office.walls().iter().take(MAX_COMPARED).all(wall_there)
    };
    1 + [1, 2, 3].iter().filter(|quarters| is_alike(quarters)).count()
}
