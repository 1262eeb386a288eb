//! A plain list of walls and doors as YAML, as recordings of corridors come with it.

use std::collections::BTreeMap;

use serde::{Deserialize, de::IgnoredAny};

use super::{Import, notes::Notes, yaml_error};
use crate::{
    MapError,
    error::HOW_TO_BEGIN,
    office::{CorridorPlan, DoorPlan, OfficePlan, SurfaceColor, WallPlan, WallSides, check::MAX_WALLS},
};

/// The file: walls as `[x1, y1, x2, y2]` with the floor to the right of the way from the first to the second point.
#[derive(Deserialize)]
struct List {
    ceiling_height: Option<f64>,
    wall_color: Option<String>,
    floor_color: Option<String>,
    walls: Option<Vec<[f64; 4]>>,
    #[serde(default)]
    doors: Vec<ListDoor>,
    #[serde(flatten)]
    others: BTreeMap<String, IgnoredAny>,
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
    #[serde(flatten)]
    others: BTreeMap<String, IgnoredAny>,
}

/// Walls whose ends are nearer than this are joined, meters.
const JOINED_M: f64 = 0.01;
/// Keys of a door that its two points say, too.
const SPARE_KEYS: [&str; 2] = ["wall", "width"];
/// Keys of another file that are told.
const MAX_KEYS_SHOWN: usize = 8;

/// Reads a list of walls and doors; `name` is used in errors, and `title` becomes the name of the map. Walls that close a
/// ring become a corridor.
pub(crate) fn read_list(name: &str, title: &str, text: &str) -> Result<Import, MapError> {
    let list: List = serde_saphyr::from_str(text).map_err(|error| yaml_error(name, &error))?;
    let Some(walls) = list.walls else {
        let keys: Vec<&str> = list.others.keys().map(String::as_str).take(MAX_KEYS_SHOWN).collect();
        let reason = format!(
            "expected walls (a list of [x1, y1, x2, y2]), or image, resolution and origin of an occupancy grid, found \
             only {}; a map of a field or a building of visloc is TOML: {HOW_TO_BEGIN}",
            if keys.is_empty() { "other data".to_owned() } else { keys.join(", ") }
        );
        return Err(MapError::Syntax { name: name.to_owned(), line: None, reason });
    };
    if walls.len() > MAX_WALLS {
        let reason = format!("expected at most {MAX_WALLS} walls, found {}", walls.len());
        return Err(MapError::Syntax { name: name.to_owned(), line: None, reason });
    }
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
    (plan.corridors, plan.walls) = rings(&walls);
    let mut notes = Notes::default();
    notes.unknown_keys(list.others.keys(), "a list of walls");
    for (i, door) in list.doors.into_iter().enumerate() {
        notes.unknown_keys(door.others.keys().filter(|key| !SPARE_KEYS.contains(&key.as_str())), "a door");
        plan.doors.push(DoorPlan {
            from: [door.x1, door.y1],
            to: [door.x2, door.y2],
            height_m: door.height.unwrap_or(2.05),
            color: color(&format!("doors[{i}].color"), door.color, SurfaceColor::RED)?,
            is_open: door.open,
        });
    }
    Ok(Import { plan, notes: notes.into_vec() })
}

/// Follows walls from end to end. Closed rings become corridors, everything else stays a wall.
fn rings(walls: &[[f64; 4]]) -> (Vec<CorridorPlan>, Vec<WallPlan>) {
    let mut is_used = vec![false; walls.len()];
    let (mut corridors, mut single) = (Vec::new(), Vec::new());
    let is_joined = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < JOINED_M;
    for begin in 0..walls.len() {
        if std::mem::replace(&mut is_used[begin], true) {
            continue;
        }
        let mut chain = vec![walls[begin]];
        let first = [chain[0][0], chain[0][1]];
        loop {
            let last = chain[chain.len() - 1];
            let end = [last[2], last[3]];
            if is_joined(end, first) {
                break;
            }
            let is_next = |i: &usize| !is_used[*i] && is_joined([walls[*i][0], walls[*i][1]], end);
            let Some(next) = (begin + 1..walls.len()).find(is_next) else { break };
            is_used[next] = true;
            chain.push(walls[next]);
        }
        let last = chain[chain.len() - 1];
        if chain.len() >= 3 && is_joined([last[2], last[3]], first) {
            corridors.push(CorridorPlan::closed(chain.iter().map(|wall| [wall[0], wall[1]]).collect()));
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
