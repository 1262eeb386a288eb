//! Which theoretical lines can be seen from where.
//!
//! The floor is cut into cells. Each knows the lines that can be seen from it, so that a pose costs what is around it
//! and not what the whole building has. Lines that only a part of the cell sees are tested with the walls around at run
//! time.

use std::ops::Range;

use nalgebra::{Point2, Vector2};
use visloc_world::office::{FreeSpace, Office, Wall};

use super::{
    lines::TheoreticalLine,
    sector::{LineColumns, Sector},
    shadows::{SLACK_M, faces},
};

/// Side of a cell, meters.
const CELL_M: f64 = 0.5;
/// Places in a cell from which lines are looked at, along each side.
const PLACES: usize = 3;
/// Cells along each side of a block, for which lines and walls in reach are looked for together.
const BLOCK: usize = 16;
/// How far apart the points of a line are that are looked at, meters.
const POINTS_APART_M: f64 = 0.5;

/// A line in the list of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Entry {
    /// Index of the line.
    pub line: u32,
    /// Whether every place of the cell sees all of it.
    pub is_certain: bool,
}

/// What a cell knows.
#[derive(Debug, Clone, Default, PartialEq)]
struct Cell {
    entries: Range<u32>,
    walls: Range<u32>,
}

/// Cells with the lines that can be seen from them.
#[derive(Debug, Clone)]
pub(super) struct SightIndex {
    min: Point2<f64>,
    columns: usize,
    rows: usize,
    cells: Vec<Cell>,
    entries: Vec<Entry>,
    /// Where the entries' lines are, to leave out at once what is beside the image.
    line_columns: LineColumns,
    walls: Vec<u32>,
}

impl SightIndex {
    /// The index of lines that are at most `range_m` from those who see them.
    pub fn new(office: &Office, lines: &[TheoreticalLine], range_m: f64) -> Self {
        let [min, max] = office.free_space().bounds_m();
        let size = (max - min) / CELL_M;
        let (columns, rows) = ((size.x.ceil() as usize).max(1), (size.y.ceil() as usize).max(1));
        let mut reach = Vec::new();
        let mut index = Self {
            min,
            columns,
            rows,
            cells: vec![Cell::default(); columns * rows],
            entries: Vec::new(),
            line_columns: LineColumns::default(),
            walls: Vec::new(),
        };
        let (size, blocks_a_row) = ((columns, rows), columns.div_ceil(BLOCK));
        for row in 0..rows {
            for column in 0..columns {
                if row % BLOCK == 0 && column == 0 {
                    let blocks = (0..blocks_a_row).map(|i| [i * BLOCK, row]);
                    reach =
                        blocks.map(|at| Reach::of_block(&min, at, size, office, lines, range_m)).collect();
                }
                index.fill(row * columns + column, office, lines, &reach[column / BLOCK], range_m);
            }
        }
        index
    }

    fn fill(&mut self, cell: usize, office: &Office, lines: &[TheoreticalLine], reach: &Reach, range_m: f64) {
        let corner =
            self.min + Vector2::new((cell % self.columns) as f64, (cell / self.columns) as f64) * CELL_M;
        let middle = corner + Vector2::repeat(0.5 * CELL_M);
        let places = free_places(office.free_space(), &corner);
        let (first_entry, first_wall) = (self.entries.len() as u32, self.walls.len() as u32);
        if !places.is_empty() {
            let is_near = |wall: &Wall| distance_m(&wall.start, &wall.end, &middle) <= range_m;
            let near =
                reach.walls.iter().map(|i| (*i, &office.walls()[*i])).filter(|(_, wall)| is_near(wall));
            let near: Vec<(usize, &Wall)> = near.collect();
            let mut has_doubt = false;
            // Neighboring ways are hidden by the same wall.
            let mut hider = 0;
            for i in reach.lines.iter().copied() {
                let line = &lines[i];
                if distance_m(&line.start, &line.end, &middle) > range_m {
                    continue;
                }
                let (seen, all) = sightings(&places, line, &near, &mut hider);
                if seen > 0 {
                    self.entries.push(Entry { line: i as u32, is_certain: seen == all });
                    self.line_columns.push(line);
                    has_doubt |= seen != all;
                }
            }
            if has_doubt {
                self.walls.extend(near.iter().map(|(i, _)| *i as u32));
            }
        }
        self.cells[cell] = Cell {
            entries: first_entry..self.entries.len() as u32,
            walls: first_wall..self.walls.len() as u32,
        };
    }

    /// The lines that can be seen from the cell of a place, and the walls that may hide those that are not certain.
    #[inline]
    pub fn around(&self, x_m: f64, y_m: f64) -> (&[Entry], &[u32]) {
        let Some(cell) = self.cell(x_m, y_m) else { return (&[], &[]) };
        (&self.entries[range(&cell.entries)], &self.walls[range(&cell.walls)])
    }

    /// Visits those of the lines around a place that may lie in a sector, in their order, with the walls that may hide
    /// them. A few that are visited lie beside it; none that lies in it is left out.
    #[inline]
    pub fn visit_in_sector(
        &self,
        place: &Point2<f64>,
        sector: &Sector,
        mut visit: impl FnMut(&Entry, &[u32]),
    ) {
        let Some(cell) = self.cell(place.x, place.y) else { return };
        let walls = &self.walls[range(&cell.walls)];
        let entries = &self.entries[range(&cell.entries)];
        self.line_columns.visit_in(range(&cell.entries), sector, |i| visit(&entries[i], walls));
    }

    #[inline]
    fn cell(&self, x_m: f64, y_m: f64) -> Option<&Cell> {
        let (column, row) = ((x_m - self.min.x) / CELL_M, (y_m - self.min.y) / CELL_M);
        let is_inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        is_inside.then(|| &self.cells[row as usize * self.columns + column as usize])
    }
}

fn range(range: &Range<u32>) -> Range<usize> {
    range.start as usize..range.end as usize
}

/// Lines and walls that may be in reach of the cells of a block.
struct Reach {
    lines: Vec<usize>,
    walls: Vec<usize>,
}

impl Reach {
    /// Those of the block that begins at a cell (column, row) of an index of this size.
    fn of_block(
        min: &Point2<f64>,
        [column, row]: [usize; 2],
        (columns, rows): (usize, usize),
        office: &Office,
        lines: &[TheoreticalLine],
        range_m: f64,
    ) -> Self {
        let size = Vector2::new(BLOCK.min(columns - column) as f64, BLOCK.min(rows - row) as f64) * CELL_M;
        let middle = min + Vector2::new(column as f64, row as f64) * CELL_M + size / 2.0;
        let reach_m = range_m + size.norm() / 2.0;
        let is_near = |start: &_, end: &_| distance_m(start, end, &middle) <= reach_m;
        let of = |(i, is_near): (usize, bool)| is_near.then_some(i);
        Self {
            lines: lines.iter().map(|l| is_near(&l.start, &l.end)).enumerate().filter_map(of).collect(),
            walls: office
                .walls()
                .iter()
                .map(|w| is_near(&w.start, &w.end))
                .enumerate()
                .filter_map(of)
                .collect(),
        }
    }
}

/// How many pairs of a place and a point of the line see each other, and how many pairs there are. `hider` is the wall that is tried
/// first: it hid the pair before.
fn sightings(
    places: &[Point2<f64>],
    line: &TheoreticalLine,
    walls: &[(usize, &Wall)],
    hider: &mut usize,
) -> (usize, usize) {
    let length_m = (line.end - line.start).norm();
    let steps = (length_m / POINTS_APART_M).ceil() as usize;
    // A little off the wall and from the ends, so that a corner does not hide what ends in it.
    let share = |i: usize| 0.01 + 0.98 * i as f64 / steps.max(1) as f64;
    let points: Vec<Point2<f64>> =
        (0..=steps).map(|i| line.start + (line.end - line.start) * share(i) + line.normal * 0.01).collect();
    let mut seen = 0;
    for place in places.iter().filter(|place| faces(place, line)) {
        for point in &points {
            let hides = |(_, wall): &(usize, &Wall)| wall.hides(place, point, SLACK_M);
            if walls.get(*hider).is_some_and(hides) {
                continue;
            }
            match walls.iter().position(hides) {
                Some(found) => *hider = found,
                None => seen += 1,
            }
        }
    }
    (seen, places.len() * points.len())
}

/// Places all over a cell where a robot can be.
fn free_places(space: &FreeSpace, corner: &Point2<f64>) -> Vec<Point2<f64>> {
    let at = |i: usize| 0.02 + (CELL_M - 0.04) * i as f64 / (PLACES - 1) as f64;
    let all = (0..PLACES * PLACES).map(|i| corner + Vector2::new(at(i % PLACES), at(i / PLACES)));
    all.filter(|place| space.contains(place.x, place.y)).collect()
}

/// Distance of a point from a straight piece, meters.
fn distance_m(start: &Point2<f64>, end: &Point2<f64>, point: &Point2<f64>) -> f64 {
    let along = end - start;
    let length2 = along.norm_squared();
    let t = if length2 > 0.0 { ((point - start).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (point - (start + along * t)).norm()
}
