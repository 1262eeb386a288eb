//! Where a robot can be: the floor, a little off the walls.

use std::ops::Range;

use nalgebra::Point2;

use super::{OfficePlan, Wall, geometry::point};

/// Least side of a cell, meters.
const CELL_M: f64 = 0.1;
/// Most cells: a place of more than 145 m x 145 m has larger ones, so that its size costs no more time.
const MAX_CELLS: f64 = (1 << 21) as f64;

/// Where a robot can be, in square cells of 0.1 m (of up to 0.35 m in places as large as allowed). Its middle does not come nearer to a
/// wall than the side of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeSpace {
    min: Point2<f64>,
    /// Side of a cell, meters.
    cell_m: f64,
    columns: usize,
    rows: usize,
    is_free: Vec<bool>,
    /// Indices of the free cells.
    free: Vec<u32>,
    is_enclosed: bool,
}

impl FreeSpace {
    pub(super) fn new(plan: &OfficePlan, walls: &[Wall]) -> Self {
        let corners = || {
            let open = plan.corridors.iter().filter(|corridor| !corridor.open_sides.is_empty());
            let open = open.flat_map(|corridor| corridor.outline.iter().copied().map(point));
            walls.iter().flat_map(|wall| [wall.start, wall.end]).chain(open)
        };
        let min = corners().fold(Point2::new(f64::MAX, f64::MAX), |m, p| m.inf(&p));
        let max = corners().fold(Point2::new(f64::MIN, f64::MIN), |m, p| m.sup(&p));
        let cell_m = CELL_M.max(((max.x - min.x) * (max.y - min.y) / MAX_CELLS).sqrt());
        let count = |size_m: f64| (size_m / cell_m).ceil().max(1.0) as usize;
        let (columns, rows) = (count(max.x - min.x), count(max.y - min.y));
        let is_free = vec![true; columns * rows];
        let mut space = Self { min, cell_m, columns, rows, is_free, free: Vec::new(), is_enclosed: true };
        if plan.corridors.is_empty() {
            for wall in walls {
                space.clear_along(wall);
            }
            space.enclose(walls);
        } else {
            space.fill(plan);
            for wall in walls {
                space.clear_along(wall);
            }
        }
        space.free = (0..space.is_free.len()).filter(|i| space.is_free[*i]).map(|i| i as u32).collect();
        space
    }

    /// Floor is what lies inside an odd number of outlines.
    fn fill(&mut self, plan: &OfficePlan) {
        let sides = plan.corridors.iter().flat_map(|corridor| {
            let next = corridor.outline.iter().cycle().skip(1);
            corridor.outline.iter().zip(next).map(|(a, b)| [point(*a), point(*b)])
        });
        let mut is_free = std::mem::take(&mut self.is_free);
        self.walk_rows(self.crossings(sides, |_| ()), |cell, _, right| is_free[cell] = right.len() % 2 == 1);
        self.is_free = is_free;
    }

    /// Goes through all cells, each with what crosses its row to the left and to the right of its middle, from left to right.
    fn walk_rows<T>(
        &self,
        crossings: Vec<Vec<(f64, T)>>,
        mut visit: impl FnMut(usize, &[(f64, T)], &[(f64, T)]),
    ) {
        for (row, mut crossings) in crossings.into_iter().enumerate() {
            crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
            for column in 0..self.columns {
                let x = self.middle(column, row).x;
                let (left, right) = crossings.split_at(crossings.partition_point(|crossing| crossing.0 <= x));
                visit(row * self.columns + column, left, right);
            }
        }
    }

    /// Where lines cross the middles of the rows: x and what is known of the line.
    fn crossings<T: Copy>(
        &self,
        lines: impl Iterator<Item = [Point2<f64>; 2]>,
        known: impl Fn(usize) -> T,
    ) -> Vec<Vec<(f64, T)>> {
        let mut crossings = vec![Vec::new(); self.rows];
        for (i, [a, b]) in lines.enumerate() {
            for row in self.rows_between(a.y.min(b.y), a.y.max(b.y)) {
                let y = self.middle(0, row).y;
                if (a.y > y) != (b.y > y) {
                    crossings[row].push((a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x), known(i)));
                }
            }
        }
        crossings
    }

    /// What the walls enclose is floor: where nobody comes from outside without crossing a wall, and where the nearest
    /// walls are seen from their front. If walls enclose nothing, everything between them is floor.
    fn enclose(&mut self, walls: &[Wall]) {
        let between = self.is_free.clone();
        let border = (0..self.rows).flat_map(|row| [(0, row), (self.columns - 1, row)]);
        let border =
            border.chain((0..self.columns).flat_map(|column| [(column, 0), (column, self.rows - 1)]));
        let mut open: Vec<(usize, usize)> = border.collect();
        while let Some((column, row)) = open.pop() {
            if !std::mem::replace(&mut self.is_free[row * self.columns + column], false) {
                continue;
            }
            let beside = [(column.wrapping_sub(1), row), (column + 1, row)];
            let above = [(column, row.wrapping_sub(1)), (column, row + 1)];
            open.extend(beside.into_iter().chain(above).filter(|(c, r)| *c < self.columns && *r < self.rows));
        }
        self.clear_behind(walls);
        self.clear_narrow();
        self.is_enclosed = self.is_free.contains(&true);
        if !self.is_enclosed {
            self.is_free = between;
        }
    }

    /// Nothing is free behind a wall that is seen from one side only: in a row of cells, the nearest walls must show
    /// their fronts.
    fn clear_behind(&mut self, walls: &[Wall]) {
        /// Both sides of a wall are at the same place, meters.
        const SAME_M: f64 = 1e-6;
        let lines = walls.iter().map(|wall| [wall.start, wall.end]);
        // A wall that goes up is seen from larger x.
        let crossings = self.crossings(lines, |i| walls[i].end.y > walls[i].start.y);
        let is_front = |wanted: bool, nearest: Option<&(f64, bool)>, sides: &[(f64, bool)]| {
            let same = |side: &&(f64, bool)| nearest.is_some_and(|n| (side.0 - n.0).abs() < SAME_M);
            nearest.is_none() || sides.iter().filter(same).any(|side| side.1 == wanted)
        };
        let mut is_free = std::mem::take(&mut self.is_free);
        self.walk_rows(crossings, |cell, left, right| {
            // Only the nearest places are looked at: a wall has two sides.
            let left_sides = &left[left.len().saturating_sub(4)..];
            let right_sides = &right[..right.len().min(4)];
            is_free[cell] &=
                is_front(true, left.last(), left_sides) && is_front(false, right.first(), right_sides);
        });
        self.is_free = is_free;
    }

    /// Nothing is free where a robot does not fit: between the two faces of a wall, for example.
    fn clear_narrow(&mut self) {
        let mut is_seen = vec![false; self.is_free.len()];
        for start in 0..self.is_free.len() {
            if is_seen[start] || !self.is_free[start] {
                continue;
            }
            let part = self.part(start, &mut is_seen);
            if !part.iter().any(|cell| self.is_roomy(*cell)) {
                for cell in part {
                    self.is_free[cell] = false;
                }
            }
        }
    }

    /// The free cells that are reached from one of them.
    fn part(&self, start: usize, is_seen: &mut [bool]) -> Vec<usize> {
        is_seen[start] = true;
        let mut part = vec![start];
        let mut next = 0;
        while next < part.len() {
            let cell = part[next];
            next += 1;
            for near in self.beside(cell) {
                if self.is_free[near] && !std::mem::replace(&mut is_seen[near], true) {
                    part.push(near);
                }
            }
        }
        part
    }

    /// The cells at all four sides of a cell.
    fn beside(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (columns, rows) = (self.columns, self.rows);
        let (column, row) = (cell % columns, cell / columns);
        [
            (column > 0).then(|| cell - 1),
            (column + 1 < columns).then(|| cell + 1),
            (row > 0).then(|| cell - columns),
            (row + 1 < rows).then(|| cell + columns),
        ]
        .into_iter()
        .flatten()
    }

    /// Whether all cells around are free too.
    fn is_roomy(&self, cell: usize) -> bool {
        let (column, row) = (cell % self.columns, cell / self.columns);
        let is_inner = column > 0 && row > 0 && column + 1 < self.columns && row + 1 < self.rows;
        is_inner
            && (row - 1..=row + 1)
                .all(|r| (column - 1..=column + 1).all(|c| self.is_free[r * self.columns + c]))
    }

    /// Nothing is free within the side of a cell of a wall.
    fn clear_along(&mut self, wall: &Wall) {
        let along = wall.end - wall.start;
        let (low, high) = (wall.start.inf(&wall.end), wall.start.sup(&wall.end));
        for row in self.rows_between(low.y - self.cell_m, high.y + self.cell_m) {
            // The part of the wall that is near to the row.
            let y = self.middle(0, row).y;
            let x_at = |y: f64| {
                let t = if along.y == 0.0 { 0.0 } else { ((y - wall.start.y) / along.y).clamp(0.0, 1.0) };
                wall.start.x + t * along.x
            };
            let is_level = along.y.abs() <= 2.0 * self.cell_m;
            let [a, b] =
                if is_level { [low.x, high.x] } else { [x_at(y - self.cell_m), x_at(y + self.cell_m)] };
            for column in self.columns_between(a.min(b) - self.cell_m, a.max(b) + self.cell_m) {
                if wall.distance_m(&self.middle(column, row)) < self.cell_m {
                    self.is_free[row * self.columns + column] = false;
                }
            }
        }
    }

    /// The rows from one y to another.
    fn rows_between(&self, from_y: f64, to_y: f64) -> Range<usize> {
        between((from_y - self.min.y) / self.cell_m, (to_y - self.min.y) / self.cell_m, self.rows)
    }

    fn columns_between(&self, from_x: f64, to_x: f64) -> Range<usize> {
        between((from_x - self.min.x) / self.cell_m, (to_x - self.min.x) / self.cell_m, self.columns)
    }

    fn middle(&self, column: usize, row: usize) -> Point2<f64> {
        Point2::new(
            self.min.x + (column as f64 + 0.5) * self.cell_m,
            self.min.y + (row as f64 + 0.5) * self.cell_m,
        )
    }

    /// Whether a robot can be at (x, y), meters.
    #[inline]
    pub fn contains(&self, x_m: f64, y_m: f64) -> bool {
        self.cell(x_m, y_m).is_some_and(|cell| self.is_free[cell])
    }

    /// The cell of a place, unless it lies outside.
    #[inline]
    fn cell(&self, x_m: f64, y_m: f64) -> Option<usize> {
        let (column, row) = ((x_m - self.min.x) / self.cell_m, (y_m - self.min.y) / self.cell_m);
        // Not a number is outside as well.
        let is_inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        is_inside.then(|| row as usize * self.columns + column as usize)
    }

    /// Least and largest (x, y) of all walls, meters.
    pub fn bounds_m(&self) -> [Point2<f64>; 2] {
        let size = nalgebra::Vector2::new(self.columns as f64, self.rows as f64) * self.cell_m;
        [self.min, self.min + size]
    }

    /// Area where a robot can be, square meters.
    pub fn area_m2(&self) -> f64 {
        self.free.len() as f64 * self.cell_m * self.cell_m
    }

    /// Whether walls or outlines enclose the floor. If not, everything between the walls counts as floor.
    pub fn is_enclosed(&self) -> bool {
        self.is_enclosed
    }

    /// The free cells as strips from least to largest (x, y), meters.
    pub fn strips_m(&self) -> impl Iterator<Item = [Point2<f64>; 2]> {
        let row_of = |cell: &u32| *cell as usize / self.columns;
        self.free.chunk_by(move |a, b| *b == a + 1 && row_of(a) == row_of(b)).map(|strip| {
            let corner = |cell: u32, right: usize, up: usize| {
                let (column, row) = (cell as usize % self.columns + right, cell as usize / self.columns + up);
                self.min + nalgebra::Vector2::new(column as f64, row as f64) * self.cell_m
            };
            [corner(strip[0], 0, 0), corner(strip[strip.len() - 1], 1, 1)]
        })
    }

    /// Areas of the parts between which no robot comes, the largest first, square meters. A pair of places, at both sides
    /// of a door, joins the parts in which they lie.
    pub fn parts_m2(&self, passages: &[[Point2<f64>; 2]]) -> Vec<f64> {
        let mut part_of = vec![u32::MAX; self.is_free.len()];
        let mut is_seen = vec![false; self.is_free.len()];
        let mut areas = Vec::new();
        for start in &self.free {
            if !is_seen[*start as usize] {
                let part = self.part(*start as usize, &mut is_seen);
                part.iter().for_each(|cell| part_of[*cell] = areas.len() as u32);
                areas.push(part.len() as f64 * self.cell_m * self.cell_m);
            }
        }
        let mut joined: Vec<usize> = (0..areas.len()).collect();
        let root = |joined: &[usize], mut part: usize| {
            while joined[part] != part {
                part = joined[part];
            }
            part
        };
        for passage in passages {
            let parts = passage.map(|at| self.cell(at.x, at.y).map_or(u32::MAX, |cell| part_of[cell]));
            if let [a, b] = parts.map(|part| part as usize)
                && a.max(b) < areas.len()
            {
                let (a, b) = (root(&joined, a), root(&joined, b));
                joined[a.max(b)] = a.min(b);
            }
        }
        let mut sums = vec![0.0; areas.len()];
        for (part, area) in areas.iter().enumerate() {
            sums[root(&joined, part)] += area;
        }
        sums.retain(|area| *area > 0.0);
        sums.sort_by(|a, b| b.total_cmp(a));
        sums
    }

    /// The free place that belongs to three numbers of [0, 1): evenly spread numbers give evenly spread places. The
    /// first one chooses the cell, the others the place in it. `None` if nothing is free.
    pub fn place(&self, choice: f64, in_cell: [f64; 2]) -> Option<Point2<f64>> {
        let last = self.free.len().checked_sub(1)?;
        let index = self.free[((choice * self.free.len() as f64) as usize).min(last)] as usize;
        let corner = self.middle(index % self.columns, index / self.columns);
        Some(Point2::new(
            corner.x + (in_cell[0] - 0.5) * self.cell_m,
            corner.y + (in_cell[1] - 0.5) * self.cell_m,
        ))
    }
}

/// The cells between two distances from the first one's edge, in cells.
fn between(from: f64, to: f64, count: usize) -> Range<usize> {
    let cell = |distance: f64| (distance.floor().max(0.0) as usize).min(count - 1);
    cell(from)..cell(to) + 1
}
