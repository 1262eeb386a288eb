//! A known map as an occupancy grid.

use nalgebra::Point2;
use visloc_core::{Occupancy, OccupancyGrid};

use crate::{Map, field::Field, office::Office};

/// Length of a cell, meters.
const CELL_M: f64 = 0.05;
/// Floor around all that is known, meters.
const MARGIN_M: f64 = 0.5;
/// Most cells on a side: 400 m.
const MOST_CELLS: f64 = 8000.0;

impl Map {
    /// The floor from above. Of a field the carpet is free but for the posts; in a building walls with closed doors are occupied, and free is where a
    /// robot can be. `None` if it is longer than 400 m.
    pub fn occupancy_grid(&self) -> Option<OccupancyGrid> {
        match self {
            Self::Field(field) => of_field(field),
            Self::Office(office) => of_office(office),
        }
    }
}

fn around(low: Point2<f64>, high: Point2<f64>) -> Option<OccupancyGrid> {
    let [columns, rows] = [0, 1].map(|axis| ((high[axis] - low[axis] + 2.0 * MARGIN_M) / CELL_M).ceil());
    let fits = columns <= MOST_CELLS && rows <= MOST_CELLS;
    let origin_m = (low.x - MARGIN_M, low.y - MARGIN_M);
    fits.then(|| OccupancyGrid::unknown(CELL_M, origin_m, (columns as usize, rows as usize)))
}

/// Sets the cells for whose middles something holds.
fn fill(grid: &mut OccupancyGrid, cell: Occupancy, holds: impl Fn(&Point2<f64>) -> bool) {
    for row in 0..grid.size.1 {
        for column in 0..grid.size.0 {
            let middle = grid.middle(column, row);
            if holds(&middle) {
                grid.set(middle.x, middle.y, cell);
            }
        }
    }
}

fn of_field(field: &Field) -> Option<OccupancyGrid> {
    let (half_x, half_y) = field.half_carpet_m();
    let mut grid = around(Point2::new(-half_x, -half_y), Point2::new(half_x, half_y))?;
    fill(&mut grid, Occupancy::Free, |at| at.x.abs() < half_x && at.y.abs() < half_y);
    for goal in field.goals() {
        for post in [-goal.post_y_m, goal.post_y_m].map(|y_m| Point2::new(goal.x_m, y_m)) {
            // A cell that is touched is occupied.
            let reach_m = goal.post_radius_m + CELL_M / 2.0;
            fill(&mut grid, Occupancy::Occupied, |at| (at - post).norm() < reach_m);
        }
    }
    Some(grid)
}

fn of_office(office: &Office) -> Option<OccupancyGrid> {
    let space = office.free_space();
    let [low, high] = space.bounds_m();
    let mut grid = around(low, high)?;
    fill(&mut grid, Occupancy::Free, |at| space.contains(at.x, at.y));
    for wall in office.walls() {
        grid.draw(&wall.start, &wall.end, Occupancy::Occupied);
    }
    // What stands open is free again, up to its frame.
    for door in office.doors().iter().filter(|door| door.is_open) {
        let inset = (door.right - door.left).normalize() * CELL_M;
        grid.draw(&(door.left + inset), &(door.right - inset), Occupancy::Free);
    }
    Some(grid)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is at a place.
    fn at(grid: &OccupancyGrid, x_m: f64, y_m: f64) -> Occupancy {
        let index = |origin_m: f64, value_m: f64| ((value_m - origin_m) / grid.cell_m) as usize;
        let (column, row) = (index(grid.origin_m.0, x_m), index(grid.origin_m.1, y_m));
        grid.rows_up().nth(row * grid.size.0 + column).unwrap()
    }

    #[test]
    fn a_field_is_free_but_for_its_posts() {
        let map = Map::built_in("robocup-spl-2024").unwrap();
        let grid = map.occupancy_grid().unwrap();
        let Map::Field(field) = &map else { panic!() };
        let (half_x, half_y) = field.half_carpet_m();
        assert_eq!(at(&grid, 0.0, 0.0), Occupancy::Free);
        assert_eq!(at(&grid, half_x - 0.1, 0.1 - half_y), Occupancy::Free);
        assert_eq!(at(&grid, half_x + 0.2, 0.0), Occupancy::Unknown);
        for goal in field.goals() {
            assert_eq!(at(&grid, goal.x_m, goal.post_y_m), Occupancy::Occupied);
            assert_eq!(at(&grid, goal.x_m, -goal.post_y_m), Occupancy::Occupied);
            assert_eq!(at(&grid, goal.x_m, 0.0), Occupancy::Free);
        }
        let num_occupied = grid.rows_up().filter(|cell| *cell == Occupancy::Occupied).count();
        assert!((4..=4 * 16).contains(&num_occupied), "{num_occupied}");
    }

    #[test]
    fn a_buildings_walls_are_occupied() {
        let map = Map::built_in("office").unwrap();
        let grid = map.occupancy_grid().unwrap();
        let Map::Office(office) = &map else { panic!() };
        for wall in office.walls() {
            let middle = nalgebra::center(&wall.start, &wall.end);
            let door = |door: &&crate::office::Door| door.is_open;
            if office.doors().iter().find(door).is_none() {
                assert_eq!(at(&grid, middle.x, middle.y), Occupancy::Occupied, "{}", wall.origin);
            }
        }
        let free_m2 = grid.rows_up().filter(|cell| *cell == Occupancy::Free).count() as f64 * CELL_M * CELL_M;
        let area_m2 = office.free_space().area_m2();
        assert!((0.75..1.05).contains(&(free_m2 / area_m2)), "{free_m2} of {area_m2} m2");
    }
}
