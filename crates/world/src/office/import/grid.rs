//! Occupancy grids of ROS' `map_server`: a YAML file beside a picture. The border between free and other cells becomes
//! outlines of corridors.

use std::path::Path;

use serde::Deserialize;

use super::{picture::GrayPicture, yaml_error};
use crate::{
    MapError,
    office::{CorridorPlan, OfficePlan},
};

/// The YAML file.
#[derive(Deserialize)]
struct Grid {
    image: String,
    resolution: f64,
    origin: [f64; 3],
    #[serde(default)]
    negate: u8,
    #[serde(default = "default_free_thresh")]
    free_thresh: f64,
}

fn default_free_thresh() -> f64 {
    0.25
}

/// Corners nearer to a straight line than this many cells are left out.
const TOLERANCE_CELLS: f64 = 1.2;
/// Smaller outlines are specks, square meters.
const MIN_AREA_M2: f64 = 0.05;

/// Whether a YAML text belongs to an occupancy grid rather than to a list of walls, which has none of these keys.
#[must_use]
pub fn is_grid(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("image:") || line.starts_with("resolution:"))
}

/// Reads a grid; its picture lies beside the file `name`, and `title` becomes the name of the map. The grid has no doors:
/// they are added to the map by hand.
///
/// # Errors
/// If the YAML or the picture cannot be read, or no cell is free. The error names the key or the picture.
pub fn read_grid(name: &str, title: &str, text: &str) -> Result<OfficePlan, MapError> {
    let grid: Grid = serde_saphyr::from_str(text).map_err(|error| yaml_error(name, &error))?;
    let refused = |key: &str, expected: &'static str, found: String| MapError::Value {
        name: name.to_owned(),
        key: key.to_owned(),
        expected,
        found,
    };
    if !(grid.resolution > 0.0 && grid.resolution < 10.0) {
        return Err(refused(
            "resolution",
            "meters a cell, above 0 and below 10",
            grid.resolution.to_string(),
        ));
    }
    if !grid.origin.iter().all(|value| value.is_finite()) {
        return Err(refused("origin", "x and y in meters and an angle", format!("{:?}", grid.origin)));
    }
    if !(grid.free_thresh > 0.0 && grid.free_thresh <= 1.0) {
        return Err(refused("free_thresh", "above 0, at most 1", grid.free_thresh.to_string()));
    }
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let picture = GrayPicture::read(&folder.join(&grid.image))
        .map_err(|found| refused("image", "a PGM or PNG picture", found))?;
    let is_free = |x: i64, y: i64| {
        picture.at(x, y).is_some_and(|value| {
            let dark = if grid.negate == 0 { 255 - value } else { value };
            f64::from(dark) / 255.0 < grid.free_thresh
        })
    };
    let (sin, cos) = grid.origin[2].sin_cos();
    let to_map = |[x, y]: [f64; 2]| {
        let (x, y) = (x * grid.resolution, (f64::from(picture.height) - y) * grid.resolution);
        [grid.origin[0] + cos * x - sin * y, grid.origin[1] + sin * x + cos * y]
    };
    let mut plan = OfficePlan::named(title);
    for ring in rings(&picture, is_free) {
        let outline: Vec<[f64; 2]> = simplified(&ring).into_iter().map(to_map).collect();
        if outline.len() >= 3 && area_m2(&outline) >= MIN_AREA_M2 {
            plan.corridors.push(CorridorPlan { outline });
        }
    }
    if plan.corridors.is_empty() {
        return Err(refused("image", "free cells with walls around", "none".to_owned()));
    }
    Ok(plan)
}

/// Closed ways around the free cells, corner by corner, with the free cells at one side.
fn rings(picture: &GrayPicture, is_free: impl Fn(i64, i64) -> bool) -> Vec<Vec<[f64; 2]>> {
    let (width, height) = (i64::from(picture.width), i64::from(picture.height));
    let index = |x: i64, y: i64| usize::try_from(y * (width + 1) + x).unwrap_or(0);
    // From every corner of the grid at most two borders go out; a border goes with the free cell at its right.
    let mut outgoing: Vec<[Option<(i64, i64)>; 2]> = vec![[None; 2]; index(width, height) + 1];
    let mut add = |from: (i64, i64), to: (i64, i64)| {
        let slots = &mut outgoing[index(from.0, from.1)];
        let slot = usize::from(slots[0].is_some());
        slots[slot] = Some(to);
    };
    for y in 0..height {
        for x in 0..width {
            if !is_free(x, y) {
                continue;
            }
            if !is_free(x, y - 1) {
                add((x, y), (x + 1, y));
            }
            if !is_free(x + 1, y) {
                add((x + 1, y), (x + 1, y + 1));
            }
            if !is_free(x, y + 1) {
                add((x + 1, y + 1), (x, y + 1));
            }
            if !is_free(x - 1, y) {
                add((x, y + 1), (x, y));
            }
        }
    }
    let mut rings = Vec::new();
    for start in (0..=height).flat_map(|y| (0..=width).map(move |x| (x, y))) {
        loop {
            let (mut at, mut ring) = (start, Vec::new());
            while let Some(to) = {
                let slots = &mut outgoing[index(at.0, at.1)];
                slots[1].take().or_else(|| slots[0].take())
            } {
                #[allow(clippy::cast_precision_loss)]
                ring.push([at.0 as f64, at.1 as f64]);
                at = to;
                if at == start {
                    break;
                }
            }
            if ring.is_empty() {
                break;
            }
            rings.push(ring);
        }
    }
    rings
}

/// A ring without the corners that lie on straight lines. After Douglas and Peucker, 1973.
fn simplified(ring: &[[f64; 2]]) -> Vec<[f64; 2]> {
    // A ring has no ends: it is cut at its first corner and at the one farthest from it.
    let far = |i: &usize, j: &usize| distance(&ring[0], &ring[*i]).total_cmp(&distance(&ring[0], &ring[*j]));
    let middle = (0..ring.len()).max_by(far).unwrap_or(0);
    let mut kept = vec![false; ring.len() + 1];
    let closed: Vec<[f64; 2]> = ring.iter().copied().chain(ring.first().copied()).collect();
    let mut open = vec![(0, middle), (middle, ring.len())];
    while let Some((from, to)) = open.pop() {
        (kept[from], kept[to]) = (true, true);
        let off = |i: &usize| distance_from_line(&closed[*i], &closed[from], &closed[to]);
        let worst = (from + 1..to).max_by(|i, j| off(i).total_cmp(&off(j)));
        if let Some(worst) = worst.filter(|worst| off(worst) > TOLERANCE_CELLS) {
            open.extend([(from, worst), (worst, to)]);
        }
    }
    (0..ring.len()).filter(|i| kept[*i]).map(|i| ring[i]).collect()
}

fn distance(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn distance_from_line(at: &[f64; 2], from: &[f64; 2], to: &[f64; 2]) -> f64 {
    let length = distance(from, to);
    if length < 1e-9 {
        return distance(at, from);
    }
    ((to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])).abs() / length
}

fn area_m2(outline: &[[f64; 2]]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    let twice: f64 = outline.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    0.5 * twice.abs()
}
