//! The border of the free cells of a grid as outlines, with walls and without.

use super::{
    drawing::{MAX_POINTS, distance_m},
    notes::{Notes, Part},
};
use crate::office::CorridorPlan;

/// What a cell is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cell {
    Free,
    Occupied,
    Unknown,
}

/// Rows of cells, the first at the top.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    pub width: usize,
    pub height: usize,
    pub values: Vec<Cell>,
}

/// Corners nearer to a straight line than this are left out: in cells, and at least in meters.
const TOLERANCE_CELLS: f64 = 1.2;
const MIN_TOLERANCE_M: f64 = 0.03;
/// Smaller outlines are specks, square meters.
const MIN_AREA_M2: f64 = 0.05;
/// Shorter borders to unknown cells between walls are gaps of the mapping, and shorter walls between them are specks; meters.
const MIN_OPEN_M: f64 = 0.3;
const MIN_WALL_M: f64 = 0.1;
/// Shorter sides are left out, meters.
const MIN_SIDE_M: f64 = 0.0501;

impl Cells {
    fn at(&self, x: i64, y: i64) -> Cell {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return Cell::Unknown };
        let is_inside = x < self.width && y < self.height;
        if is_inside { self.values[y * self.width + x] } else { Cell::Unknown }
    }

    fn is_free(&self, x: i64, y: i64) -> bool {
        self.at(x, y) == Cell::Free
    }
}

/// A closed way around free cells, which lie at its right: corners in cells, and whether the side that begins there is a
/// wall.
type Ring = Vec<([f64; 2], bool)>;

/// The outlines of the free cells in meters from the lower left corner of the picture, y up.
pub(super) fn outlines(cells: &Cells, cell_m: f64, notes: &mut Notes) -> Result<Vec<CorridorPlan>, String> {
    let mut corridors = Vec::new();
    let mut effort = 0;
    let height = cells.height as f64;
    for ring in rings(cells)? {
        let corners = simplified(&with_long_sides(ring, cell_m), cell_m, &mut effort)?;
        let outline: Vec<[f64; 2]> =
            corners.iter().map(|([x, y], _)| [x * cell_m, (height - y) * cell_m]).collect();
        if outline.len() < 3 || area(&corners) * cell_m * cell_m < MIN_AREA_M2 {
            let part = Part { what: "outline of free cells or in them".to_owned(), ..Part::default() };
            notes.passed_over(&part, "smaller than 0.05 square meters");
            continue;
        }
        let open_sides = (0..corners.len()).filter(|side| !corners[*side].1).collect();
        corridors.push(CorridorPlan { outline, open_sides });
    }
    let num_open: usize = corridors.iter().map(|corridor| corridor.open_sides.len()).sum();
    for _ in 0..num_open {
        let part = Part { what: "border from free to unknown cells".to_owned(), ..Part::default() };
        notes.taken(&part, "as the end of the floor, without a wall");
    }
    Ok(corridors)
}

/// Right, down, left, up: the way along the upper, right, lower and left side of a free cell.
const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// Closed ways around the free cells, corner by corner.
fn rings(cells: &Cells) -> Result<Vec<Ring>, String> {
    let outgoing = borders(cells);
    trace(cells, outgoing)
}

/// Which steps begin at each corner of the grid, as bits.
fn borders(cells: &Cells) -> Vec<u8> {
    let columns = cells.width + 1;
    let mut outgoing = vec![0; columns * (cells.height + 1)];
    for y in 0..cells.height {
        for x in 0..cells.width {
            let (column, row) = (x as i64, y as i64);
            if !cells.is_free(column, row) {
                continue;
            }
            // Each side begins where the one before ends.
            let corners =
                [y * columns + x, y * columns + x + 1, (y + 1) * columns + x + 1, (y + 1) * columns + x];
            for (step, corner) in corners.into_iter().enumerate() {
                let (dx, dy) = beyond(step);
                if !cells.is_free(column + dx, row + dy) {
                    outgoing[corner] |= 1 << step;
                }
            }
        }
    }
    outgoing
}

/// From a free cell to the one across the side that a step goes along.
fn beyond(step: usize) -> (i64, i64) {
    let (dx, dy) = STEPS[step];
    (dy, -dx)
}

fn trace(cells: &Cells, mut outgoing: Vec<u8>) -> Result<Vec<Ring>, String> {
    let columns = cells.width + 1;
    let mut num_corners = 0;
    let mut rings = Vec::new();
    for start in 0..outgoing.len() {
        while outgoing[start] != 0 {
            let mut ring: Ring = Vec::new();
            let (mut at, mut last) = (start, None);
            while let Some(step) = (0..4).find(|step| outgoing[at] >> step & 1 == 1) {
                outgoing[at] &= !(1 << step);
                let (x, y) = ((at % columns) as i64, (at / columns) as i64);
                // The free cell is at the right of the step; what is beyond it decides whether there is a wall.
                let (cell_x, cell_y) = [(x, y), (x - 1, y), (x - 1, y - 1), (x, y - 1)][step];
                let (dx, dy) = beyond(step);
                let is_wall = cells.at(cell_x + dx, cell_y + dy) == Cell::Occupied;
                if last != Some((step, is_wall)) {
                    ring.push(([x as f64, y as f64], is_wall));
                    num_corners += 1;
                }
                last = Some((step, is_wall));
                at = ((y + STEPS[step].1) * columns as i64 + x + STEPS[step].0) as usize;
                if at == start {
                    break;
                }
            }
            rings.push(ring);
        }
        if num_corners > 20 * MAX_POINTS {
            return Err("a picture whose free cells are noise, with millions of corners".to_owned());
        }
    }
    Ok(rings)
}

/// The ring with its short gaps between walls as walls, and with short walls between unknown cells as unknown.
fn with_long_sides(mut ring: Ring, cell_m: f64) -> Ring {
    for (is_wall, min_m) in [(false, MIN_OPEN_M), (true, MIN_WALL_M)] {
        let Some(first) = (0..ring.len()).find(|i| ring[*i].1 != ring[(i + ring.len() - 1) % ring.len()].1)
        else {
            return ring;
        };
        ring.rotate_left(first);
        let mut from = 0;
        while from < ring.len() {
            let to = (from..ring.len()).find(|i| ring[*i].1 != ring[from].1).unwrap_or(ring.len());
            let corner = |i: usize| &ring[i % ring.len()].0;
            let length_m: f64 =
                (from..to).map(|i| distance_m(corner(i), corner(i + 1))).sum::<f64>() * cell_m;
            if ring[from].1 == is_wall && length_m < min_m {
                ring[from..to].iter_mut().for_each(|corner| corner.1 = !is_wall);
            }
            from = to;
        }
    }
    ring
}

/// A ring without the corners that lie on straight lines. Where walls begin and end, corners stay. After Douglas and
/// Peucker, 1973.
fn simplified(ring: &Ring, cell_m: f64, effort: &mut usize) -> Result<Ring, String> {
    /// Comparisons of corners with lines; a plan needs a hundredth of it.
    const MAX_EFFORT: usize = 300_000_000;
    let tolerance = TOLERANCE_CELLS.max(MIN_TOLERANCE_M / cell_m);
    let Some((first, _)) = ring.first() else { return Ok(Vec::new()) };
    let num = ring.len();
    let at = |i: usize| &ring[i % num].0;
    // A ring has no ends: it is cut at its first corner and at the one farthest from it.
    let middle =
        (0..num).max_by(|i, j| distance_m(first, at(*i)).total_cmp(&distance_m(first, at(*j)))).unwrap_or(0);
    let mut kept = vec![false; num + 1];
    let mut cuts: Vec<usize> = (1..num).filter(|i| *i == middle || ring[*i].1 != ring[i - 1].1).collect();
    cuts.insert(0, 0);
    cuts.push(num);
    let mut open: Vec<(usize, usize)> = cuts.windows(2).map(|pair| (pair[0], pair[1])).collect();
    while let Some((from, to)) = open.pop() {
        (kept[from], kept[to]) = (true, true);
        *effort += to - from;
        if *effort > MAX_EFFORT {
            return Err("a picture whose free cells have borders that cannot be straightened".to_owned());
        }
        let off = |i: &usize| distance_from_line(at(*i), at(from), at(to));
        let worst = (from + 1..to).max_by(|i, j| off(i).total_cmp(&off(j)));
        if let Some(worst) = worst.filter(|worst| off(worst) > tolerance) {
            open.extend([(from, worst), (worst, to)]);
        }
    }
    let mut corners: Ring = Vec::new();
    for i in (0..num).filter(|i| kept[*i]) {
        if corners.last().is_none_or(|last| distance_m(&last.0, at(i)) * cell_m >= MIN_SIDE_M) {
            corners.push(ring[i]);
        }
    }
    while corners.len() > 1 && distance_m(&corners[0].0, &corners[corners.len() - 1].0) * cell_m < MIN_SIDE_M
    {
        corners.pop();
    }
    Ok(corners)
}

fn distance_from_line(at: &[f64; 2], from: &[f64; 2], to: &[f64; 2]) -> f64 {
    let length = distance_m(from, to);
    if length < 1e-9 {
        return distance_m(at, from);
    }
    ((to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])).abs() / length
}

/// Area of a ring, square cells.
fn area(ring: &Ring) -> f64 {
    let next = ring.iter().cycle().skip(1);
    let twice: f64 = ring.iter().zip(next).map(|((a, _), (b, _))| a[0] * b[1] - a[1] * b[0]).sum();
    0.5 * twice.abs()
}
