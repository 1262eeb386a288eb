//! The states: tiles of the ground with a few headings each.

use std::f64::consts::TAU;

use visloc_core::geom::{PlanarPose, angle};

use crate::Region;

/// Where the columns of a grid run to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Towards +x of the map; rows run towards +y.
    PlusX,
    /// Towards -x of the map; rows run towards -y.
    MinusX,
}

/// A tile with a heading. Rows run to the left of heading 0, which looks along the columns; headings are counted
/// clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// Tile along the field.
    pub column: usize,
    /// Tile across the field, from right to left for a robot with heading 0.
    pub row: usize,
    /// Heading, clockwise in steps of a full turn divided by the number of headings.
    pub heading: usize,
}

/// Tiles and headings, numbered so that with 8 rows and 4 headings state = 32 column + 4 row + heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    num_columns: usize,
    num_rows: usize,
    num_headings: usize,
    tile_m: f64,
    /// The grid's frame: origin at the outer corner of the first tile, x along the columns, y along the rows.
    world_from_grid: PlanarPose,
}

impl Grid {
    /// A grid of whole tiles over a region; its middle is the region's middle. A tile is at least a millimeter, and
    /// there is at least one tile and one heading.
    pub fn new(region: &Region, tile_m: f64, num_headings: usize, direction: Direction) -> Self {
        let tile_m = tile_m.max(1e-3);
        let (size_x_m, size_y_m) = (region.max_x_m - region.min_x_m, region.max_y_m - region.min_y_m);
        let (num_columns, num_rows) = (num_tiles(size_x_m, tile_m), num_tiles(size_y_m, tile_m));
        let yaw_rad = if direction == Direction::PlusX { 0.0 } else { std::f64::consts::PI };
        let middle = PlanarPose::new(
            f64::midpoint(region.min_x_m, region.max_x_m),
            f64::midpoint(region.min_y_m, region.max_y_m),
            yaw_rad,
        );
        let corner =
            PlanarPose::new(-0.5 * tile_m * num_columns as f64, -0.5 * tile_m * num_rows as f64, 0.0);
        let num_headings = num_headings.max(1);
        Self { num_columns, num_rows, num_headings, tile_m, world_from_grid: middle.compose(&corner) }
    }

    /// Number of states.
    pub fn num_states(&self) -> usize {
        self.num_columns * self.num_rows * self.num_headings
    }

    /// Tiles along the field.
    pub fn num_columns(&self) -> usize {
        self.num_columns
    }

    /// Tiles across the field.
    pub fn num_rows(&self) -> usize {
        self.num_rows
    }

    /// Headings of each tile.
    pub fn num_headings(&self) -> usize {
        self.num_headings
    }

    /// Side of a tile, meters.
    pub fn tile_m(&self) -> f64 {
        self.tile_m
    }

    /// Angle between two headings, radians.
    pub fn heading_step_rad(&self) -> f64 {
        TAU / self.num_headings as f64
    }

    /// Number of a state.
    #[inline]
    pub fn index(&self, state: State) -> usize {
        (state.column * self.num_rows + state.row) * self.num_headings + state.heading
    }

    /// State of a number.
    #[inline]
    pub fn state(&self, index: usize) -> State {
        let (tile, heading) = (index / self.num_headings, index % self.num_headings);
        State { column: tile / self.num_rows, row: tile % self.num_rows, heading }
    }

    /// Yaw of a heading in the grid's frame, counter-clockwise, radians.
    #[inline]
    pub fn heading_rad(&self, heading: usize) -> f64 {
        -(heading as f64) * self.heading_step_rad()
    }

    /// The part of the map that the tiles cover.
    pub fn region(&self) -> Region {
        let corner = self.world_from_grid.position();
        let size_m = |tiles: usize| tiles as f64 * self.tile_m;
        let opposite = PlanarPose::new(size_m(self.num_columns), size_m(self.num_rows), 0.0);
        let opposite = self.world_from_grid.compose(&opposite).position();
        Region {
            min_x_m: corner.x.min(opposite.x),
            max_x_m: corner.x.max(opposite.x),
            min_y_m: corner.y.min(opposite.y),
            max_y_m: corner.y.max(opposite.y),
        }
    }

    /// The middle of a state: center of its tile, its heading.
    pub fn pose(&self, index: usize) -> PlanarPose {
        let state = self.state(index);
        let center = |tile: usize| (tile as f64 + 0.5) * self.tile_m;
        let grid_from_robot =
            PlanarPose::new(center(state.column), center(state.row), self.heading_rad(state.heading));
        self.world_from_grid.compose(&grid_from_robot)
    }

    /// The state whose middle is nearest to a pose; poses outside belong to the outermost tiles.
    pub fn nearest(&self, world_from_robot: &PlanarPose) -> usize {
        let grid_from_robot = world_from_robot.relative_to(&self.world_from_grid);
        let column = tile_of(grid_from_robot.x_m / self.tile_m, self.num_columns);
        let row = tile_of(grid_from_robot.y_m / self.tile_m, self.num_rows);
        let steps = (-grid_from_robot.yaw_rad / self.heading_step_rad()).round();
        let heading = steps.rem_euclid(self.num_headings as f64) as usize % self.num_headings;
        self.index(State { column, row, heading })
    }

    /// Whether two states touch: at most one tile and one heading apart.
    pub fn are_neighbors(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.state(a), self.state(b));
        let turn = a.heading.abs_diff(b.heading);
        a.column.abs_diff(b.column) <= 1
            && a.row.abs_diff(b.row) <= 1
            && turn.min(self.num_headings - turn) <= 1
    }

    /// A state's heading turned clockwise by a number of steps, which may be negative.
    #[inline]
    pub fn turned(&self, heading: usize, steps: i32) -> usize {
        let count = i64::try_from(self.num_headings).unwrap_or(i64::MAX);
        let from = i64::try_from(heading).unwrap_or(0);
        usize::try_from((from + i64::from(steps)).rem_euclid(count)).unwrap_or(0)
    }

    /// Whether a pose lies within the tile of a state, whatever its heading.
    pub fn is_in_tile(&self, index: usize, world_from_robot: &PlanarPose) -> bool {
        let middle = PlanarPose { yaw_rad: self.world_from_grid.yaw_rad, ..self.pose(index) };
        let offset = world_from_robot.relative_to(&middle);
        offset.x_m.abs() <= self.tile_m / 2.0 && offset.y_m.abs() <= self.tile_m / 2.0
    }

    /// Difference between a pose's heading and that of a state, radians in (-pi, pi].
    pub fn heading_error_rad(&self, index: usize, world_from_robot: &PlanarPose) -> f64 {
        angle::difference(world_from_robot.yaw_rad, self.pose(index).yaw_rad)
    }
}

fn num_tiles(size_m: f64, tile_m: f64) -> usize {
    // A little less than a whole tile too many is an error of rounding.
    ((size_m / tile_m - 1e-6).ceil().max(1.0) as usize).min(10_000)
}

fn tile_of(tiles: f64, count: usize) -> usize {
    (tiles.floor().max(0.0) as usize).min(count - 1)
}
