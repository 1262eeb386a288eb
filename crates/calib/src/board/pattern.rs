//! All boards behind one type.

use nalgebra::{Point2, Point3};
use thiserror::Error;

use super::{AprilGrid, Checkerboard, NUM_CODES};

/// The board's own frame: x and y in its plane, z away from whoever looks at its front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardFrame {}

/// A flat board with corners that can be found in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Board {
    /// Black and white squares.
    Checkerboard(Checkerboard),
    /// Tags with numbers.
    AprilGrid(AprilGrid),
}

/// A board that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("board: expected {expected}, found {found}")]
pub struct BoardError {
    /// What is allowed.
    pub expected: String,
    /// What was given.
    pub found: String,
}

/// Fewest and most columns or rows.
const SIDES: std::ops::RangeInclusive<usize> = 2..=100;

impl Board {
    /// Checks the dimensions; every other function takes them for granted.
    ///
    /// # Errors
    /// The first dimension that is out of its range.
    pub fn check(&self) -> Result<(), BoardError> {
        let (columns, rows, side_m) = match self {
            Self::Checkerboard(b) => (b.columns, b.rows, b.square_m),
            Self::AprilGrid(b) => (b.columns, b.rows, b.tag_m),
        };
        let refuse = |expected: &str, found: String| Err(BoardError { expected: expected.to_owned(), found });
        if !SIDES.contains(&columns) || !SIDES.contains(&rows) {
            return refuse("2 to 100 columns and rows", format!("{columns} x {rows}"));
        }
        if !(side_m > 0.0 && side_m < 100.0) {
            return refuse("a side above 0 and below 100 m", format!("{side_m:?} m"));
        }
        if let Self::Checkerboard(_) = self
            && columns.min(rows) < 3
        {
            return refuse(
                "a checkerboard with 3 inner corners or more each way",
                format!("{columns} x {rows}"),
            );
        }
        if let Self::AprilGrid(grid) = self {
            let last = grid.first_id.saturating_add(columns * rows);
            if last > NUM_CODES {
                return refuse(
                    &format!("tags below {NUM_CODES}"),
                    format!("a grid that ends with tag {}", last - 1),
                );
            }
            if !(0.05..=2.0).contains(&grid.spacing) || !(1..=2).contains(&grid.border_cells) {
                let found = format!("a gap of {:?} and a border of {}", grid.spacing, grid.border_cells);
                return refuse("a gap of 0.05 to 2 times the tag and a border of 1 or 2 cells", found);
            }
        }
        Ok(())
    }

    /// How many corners it has. Corner numbers go from 0 to one less.
    pub fn num_corners(&self) -> usize {
        match self {
            Self::Checkerboard(b) => b.columns * b.rows,
            Self::AprilGrid(b) => 4 * b.columns * b.rows,
        }
    }

    /// Place of a corner on the board, meters; z is 0.
    pub fn corner_in_board(&self, id: usize) -> Point3<f64> {
        let p = match self {
            Self::Checkerboard(b) => b.corner_in_board(id),
            Self::AprilGrid(b) => b.corner_in_board(id),
        };
        Point3::new(p.x, p.y, 0.0)
    }

    /// Whether a point of the board's plane is black; `None` outside of the board.
    pub fn is_black(&self, point_in_board: &Point2<f64>) -> Option<bool> {
        match self {
            Self::Checkerboard(b) => b.is_black(point_in_board),
            Self::AprilGrid(b) => b.is_black(point_in_board),
        }
    }

    /// Squares that draw the board on white, one over the other: upper left corner and side, meters, and whether it is black.
    pub fn squares(&self) -> Vec<(Point2<f64>, f64, bool)> {
        match self {
            Self::Checkerboard(b) => b.squares(),
            Self::AprilGrid(b) => b.squares(),
        }
    }

    /// Lowest and highest x and y of the board with its white margin, meters.
    pub fn bounds_m(&self) -> [Point2<f64>; 2] {
        match self {
            Self::Checkerboard(b) => b.bounds_m(),
            Self::AprilGrid(b) => b.bounds_m(),
        }
    }

    /// Middle of the board, meters.
    pub fn center_in_board(&self) -> Point3<f64> {
        let [low, high] = self.bounds_m();
        let middle = nalgebra::center(&low, &high);
        Point3::new(middle.x, middle.y, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHECKERS: Board = Board::Checkerboard(Checkerboard { columns: 9, rows: 6, square_m: 0.02 });
    const TAGS: Board = Board::AprilGrid(AprilGrid {
        columns: 4,
        rows: 3,
        tag_m: 0.1,
        spacing: 0.3,
        first_id: 5,
        border_cells: 2,
    });

    #[test]
    fn every_corner_lies_between_black_and_white() {
        for board in [CHECKERS, TAGS] {
            board.check().unwrap();
            for id in 0..board.num_corners() {
                let p = board.corner_in_board(id);
                let black = |dx: f64, dy: f64| board.is_black(&Point2::new(p.x + dx, p.y + dy)).unwrap();
                let d = 0.002;
                assert_eq!(black(d, d), black(-d, -d), "{id}");
                assert_eq!(black(d, -d), black(-d, d), "{id}");
                assert_ne!(black(d, d), black(d, -d), "{id}");
            }
        }
        assert!(CHECKERS.is_black(&Point2::new(-0.01, -0.01)).unwrap());
        assert_eq!(CHECKERS.is_black(&Point2::new(1.0, 0.0)), None);
    }

    #[test]
    fn drawn_squares_are_the_board() {
        for board in [CHECKERS, TAGS] {
            let squares = board.squares();
            let [low, high] = board.bounds_m();
            for i in 0..60 {
                for j in 0..60 {
                    let share =
                        nalgebra::Vector2::new((f64::from(i) + 0.537) / 60.0, (f64::from(j) + 0.437) / 60.0);
                    let p = low + (high - low).component_mul(&share);
                    let inside = |s: &&(Point2<f64>, f64, bool)| {
                        (0.0..s.1).contains(&(p.x - s.0.x)) && (0.0..s.1).contains(&(p.y - s.0.y))
                    };
                    let drawn = squares.iter().rev().find(inside).is_some_and(|s| s.2);
                    assert_eq!(board.is_black(&p), Some(drawn), "{p}");
                }
            }
        }
    }

    #[test]
    fn impossible_boards_are_refused() {
        let board = |columns, square_m| Board::Checkerboard(Checkerboard { columns, rows: 6, square_m });
        assert!(board(1, 0.02).check().is_err() && board(9, 0.0).check().is_err());
        assert!(board(9, f64::NAN).check().is_err());
        let Board::AprilGrid(grid) = TAGS else { unreachable!() };
        let error = Board::AprilGrid(AprilGrid { first_id: 580, ..grid }).check().unwrap_err();
        assert_eq!(error.to_string(), "board: expected tags below 587, found a grid that ends with tag 591");
    }
}
