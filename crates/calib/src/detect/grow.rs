//! From saddle points to grids: a seed and its neighbors, neighbors of neighbors, and so on.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use nalgebra::{Point2, Vector2};

use crate::saddles::{FloatImage, Saddle, SaddleIndex};

/// Place in a grid; the seed is (0, 0).
pub(super) type Cell = (i32, i32);

/// Saddle points by their place in the grid.
pub(super) type Grid = BTreeMap<Cell, usize>;

/// How far the next corner may be from where it is expected, as a share of the step.
const TOLERANCE: f64 = 0.35;
/// How far an edge may turn away from the line to the next corner, radians.
const MAX_BEND_RAD: f64 = 0.35;
/// Longest side of a square, as a share of the image's longer side.
const MAX_STEP: f64 = 0.4;
/// So many neighbors along an edge are tried for a seed.
const MAX_TRIED: usize = 5;

/// What growing needs to know.
pub(super) struct Corners<'a> {
    pub image: &'a FloatImage,
    pub saddles: &'a [Saddle],
    pub index: &'a SaddleIndex,
}

impl Corners<'_> {
    /// The grid around a seed; empty if the seed has no neighbors in two directions.
    pub fn grow(&self, seed: usize) -> Grid {
        let mut grid = Grid::from([((0, 0), seed)]);
        let mut used = BTreeSet::from([seed]);
        let Some(steps) = self.first_steps(seed) else { return Grid::new() };
        let mut queue = VecDeque::from([((0, 0), steps)]);
        while let Some((cell, steps)) = queue.pop_front() {
            for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
                let next = neighbor(cell, axis, sign);
                if grid.contains_key(&next) {
                    continue;
                }
                let Some(found) = self.step(&grid, cell, axis, sign, &steps) else { continue };
                if !used.insert(found) {
                    continue;
                }
                let mut steps = steps;
                steps[axis] = (self.saddles[found].px - self.saddles[grid[&cell]].px) * f64::from(sign);
                grid.insert(next, found);
                queue.push_back((next, steps));
            }
        }
        prune(&mut grid);
        grid
    }

    /// Steps to the neighbors of a seed along its two edges.
    fn first_steps(&self, seed: usize) -> Option<[Vector2<f64>; 2]> {
        let saddle = &self.saddles[seed];
        let along = |angle: f64| self.along_edge(seed, angle).map(|i| self.saddles[i].px - saddle.px);
        let [a, b] = saddle.edges_rad;
        let both =
            |angle: f64| along(angle).or_else(|| along(angle + std::f64::consts::PI).map(|step| -step));
        Some([both(a)?, both(b)?])
    }

    /// The nearest saddle point at the other end of an edge.
    fn along_edge(&self, from: usize, angle: f64) -> Option<usize> {
        let start = self.saddles[from].px;
        let reach = MAX_STEP * self.image.width().max(self.image.height()) as f64;
        let mut near: Vec<(f64, usize)> = self
            .index
            .within(&start, reach)
            .filter(|i| *i != from)
            .map(|i| ((self.saddles[i].px - start).norm(), i))
            .filter(|(_, i)| {
                let d = self.saddles[*i].px - start;
                visloc_core::geom::angle::difference(d.y.atan2(d.x), angle).abs() < MAX_BEND_RAD
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.iter().take(MAX_TRIED).map(|(_, i)| *i).find(|i| self.is_edge(from, *i))
    }

    /// The neighbor of a cell in a direction, near the place where it is expected.
    fn step(
        &self,
        grid: &Grid,
        cell: Cell,
        axis: usize,
        sign: i32,
        steps: &[Vector2<f64>; 2],
    ) -> Option<usize> {
        let from = grid[&cell];
        let here = self.saddles[from].px;
        // The step before this one is the best guess of the next.
        let before = grid.get(&neighbor(cell, axis, -sign)).map(|i| here - self.saddles[*i].px);
        let step = before.unwrap_or(steps[axis] * f64::from(sign));
        let expected: Point2<f64> = here + step;
        let radius = TOLERANCE * step.norm();
        let mut near: Vec<(f64, usize)> = self
            .index
            .within(&expected, radius)
            .filter(|i| *i != from)
            .map(|i| ((self.saddles[i].px - expected).norm(), i))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.iter().map(|(_, i)| *i).find(|i| self.is_edge(from, *i))
    }

    /// Whether an edge runs from one saddle point to the other, with the same side bright all along.
    fn is_edge(&self, from: usize, to: usize) -> bool {
        let (a, b) = (&self.saddles[from], &self.saddles[to]);
        let along = b.px - a.px;
        let angle = along.y.atan2(along.x);
        let (start, bend) = a.nearest_edge(angle);
        let (end, other_bend) = b.nearest_edge(angle + std::f64::consts::PI);
        if bend > MAX_BEND_RAD || other_bend > MAX_BEND_RAD {
            return false;
        }
        let left = a.edge_contrast(self.image, start);
        if left * b.edge_contrast(self.image, end) >= 0.0 {
            return false;
        }
        let beside = Vector2::new(-along.y, along.x) * 0.2;
        let middle = a.px + along * 0.5;
        let contrast = self.image.sample(&(middle - beside)) - self.image.sample(&(middle + beside));
        contrast * left > 0.0 && contrast.abs() > 0.3 * a.contrast.min(b.contrast)
    }
}

fn neighbor((i, j): Cell, axis: usize, sign: i32) -> Cell {
    if axis == 0 { (i + sign, j) } else { (i, j + sign) }
}

/// Takes off what hangs on a single corner: the board has no such corners, clutter beside it has.
fn prune(grid: &mut Grid) {
    loop {
        let num_neighbors = |cell: Cell| {
            let around = [(0, 1), (0, -1), (1, 1), (1, -1)];
            around.into_iter().filter(|(axis, sign)| grid.contains_key(&neighbor(cell, *axis, *sign))).count()
        };
        let loose: Vec<Cell> = grid.keys().copied().filter(|cell| num_neighbors(*cell) < 2).collect();
        if loose.is_empty() {
            break;
        }
        for cell in loose {
            grid.remove(&cell);
        }
    }
}
