//! A plain list of walls and doors as YAML, as recordings of corridors come with it.

use serde::Deserialize;

use super::yaml_error;
use crate::{
    MapError,
    office::{CorridorPlan, DoorPlan, OfficePlan, SurfaceColor, WallPlan, WallSides},
};

/// The file: walls as `[x1, y1, x2, y2]` with the floor to the right of the way from the first to the second point.
#[derive(Deserialize)]
struct List {
    ceiling_height: Option<f64>,
    wall_color: Option<String>,
    floor_color: Option<String>,
    #[serde(default)]
    walls: Vec<[f64; 4]>,
    #[serde(default)]
    doors: Vec<ListDoor>,
}

#[derive(Deserialize)]
struct ListDoor {
    x1: f64,
    y1: f64,
    x2: f64,
    y2: f64,
    height: Option<f64>,
    color: Option<String>,
    #[serde(default)]
    open: bool,
}

/// Walls whose ends are nearer than this are joined, meters.
const JOINED_M: f64 = 0.01;

/// Reads a list of walls and doors; `name` is used in errors, and `title` becomes the name of the map. Walls that close a
/// ring become a corridor.
///
/// # Errors
/// If the text is not YAML of this form; the error names the line.
pub fn read_list(name: &str, title: &str, text: &str) -> Result<OfficePlan, MapError> {
    let list: List = serde_saphyr::from_str(text).map_err(|error| yaml_error(name, &error))?;
    let color = |key: &str, text: Option<String>, default: SurfaceColor| match text {
        None => Ok(default),
        Some(text) => text.parse().map_err(|reason| MapError::Syntax {
            name: name.to_owned(),
            line: None,
            reason: format!("{key}: {reason}"),
        }),
    };
    let empty = OfficePlan::named(title);
    let mut plan = OfficePlan {
        ceiling_height_m: list.ceiling_height.unwrap_or(empty.ceiling_height_m),
        wall_color: color("wall_color", list.wall_color, empty.wall_color)?,
        floor_color: color("floor_color", list.floor_color, empty.floor_color)?,
        ..empty
    };
    (plan.corridors, plan.walls) = rings(&list.walls);
    for (i, door) in list.doors.into_iter().enumerate() {
        plan.doors.push(DoorPlan {
            from: [door.x1, door.y1],
            to: [door.x2, door.y2],
            height_m: door.height.unwrap_or(2.05),
            color: color(&format!("doors[{i}].color"), door.color, SurfaceColor::RED)?,
            is_open: door.open,
        });
    }
    Ok(plan)
}

/// Follows walls from end to end. Closed rings become corridors, everything else stays a wall.
fn rings(walls: &[[f64; 4]]) -> (Vec<CorridorPlan>, Vec<WallPlan>) {
    let mut left: Vec<[f64; 4]> = walls.to_vec();
    let (mut corridors, mut single) = (Vec::new(), Vec::new());
    let is_joined = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < JOINED_M;
    while !left.is_empty() {
        let mut chain = vec![left.remove(0)];
        let first = [chain[0][0], chain[0][1]];
        loop {
            let last = chain[chain.len() - 1];
            let end = [last[2], last[3]];
            if is_joined(end, first) {
                break;
            }
            let Some(next) = left.iter().position(|wall| is_joined([wall[0], wall[1]], end)) else { break };
            chain.push(left.remove(next));
        }
        let last = chain[chain.len() - 1];
        if chain.len() >= 3 && is_joined([last[2], last[3]], first) {
            corridors.push(CorridorPlan { outline: chain.iter().map(|wall| [wall[0], wall[1]]).collect() });
        } else {
            single.extend(chain.iter().map(|wall| WallPlan {
                from: [wall[0], wall[1]],
                to: [wall[2], wall[3]],
                sides: WallSides::Right,
            }));
        }
    }
    (corridors, single)
}
