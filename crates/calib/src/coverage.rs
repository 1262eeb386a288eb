//! What the pictures of a board cover, and what to photograph next.

use std::fmt;

use crate::{Calibration, View};

/// Cells of the coverage map along x and y.
const CELLS: (usize, usize) = (8, 6);
/// A board counts as tilted from here on, radians.
const TILTED_RAD: f64 = 0.26;
/// Pictures that a calibration should have.
const GOOD_VIEWS: usize = 12;
/// Widths of the board, as shares of the image's diagonal, that count as near and far.
const NEAR: f64 = 0.55;
const FAR: f64 = 0.4;

/// What the pictures cover.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Cells along x and y.
    pub cells: (usize, usize),
    /// Corners in each cell, rows from the top.
    pub counts: Vec<usize>,
    /// Share of the cells with a corner, 0 to 1.
    pub covered: f64,
    /// Pictures with the left, right, upper and lower side of the board nearer by 15 degrees or more.
    pub tilted: [usize; 4],
    /// Least and largest extent of the board in a picture, as shares of the image's diagonal.
    pub extents: (f64, f64),
    /// What to photograph next, the most useful first.
    pub advice: Vec<Advice>,
}

/// A picture that is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Advice {
    /// Column and row, 0 to 2 each, of the ninth of the image that has too few corners.
    Region(usize, usize),
    /// Side that should be nearer: left, right, upper, lower.
    Tilt(usize),
    /// The board should fill more of the image.
    Nearer,
    /// The board should also be farther away.
    Farther,
    /// More pictures: how many.
    MoreViews(usize),
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Region(1, 1) => write!(f, "hold the board in the middle of the image"),
            Self::Region(column, row) => {
                let (x, y) = (["left", "", "right"][column % 3], ["upper", "", "lower"][row % 3]);
                let place = [y, x].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ");
                let part = if x.is_empty() || y.is_empty() { "border" } else { "corner" };
                write!(f, "hold the board into the {place} {part} of the image, up to the edge")
            }
            Self::Tilt(side) => {
                let side = ["left", "right", "upper", "lower"][side % 4];
                write!(f, "tilt the board by 30 degrees with its {side} side towards the camera")
            }
            Self::Nearer => write!(f, "go nearer: the board should once fill most of the image"),
            Self::Farther => write!(f, "go farther away: the board should once fill a third of the image"),
            Self::MoreViews(count) => write!(f, "take {count} more pictures, each from another direction"),
        }
    }
}

/// The coverage of a calibration's pictures.
pub fn coverage(calibration: &Calibration) -> Coverage {
    let (width, height) = calibration.camera.size_px();
    let size = (f64::from(width), f64::from(height));
    let counts = counts(calibration, size, CELLS);
    let extents = extents(calibration, size.0.hypot(size.1));
    let tilted = tilted(&calibration.views);
    let empty = counts.iter().filter(|count| **count == 0).count();
    Coverage {
        cells: CELLS,
        covered: 1.0 - empty as f64 / counts.len() as f64,
        advice: advice(calibration, size, &tilted, extents),
        counts,
        tilted,
        extents,
    }
}

fn counts(calibration: &Calibration, size: (f64, f64), cells: (usize, usize)) -> Vec<usize> {
    let mut counts = vec![0; cells.0 * cells.1];
    for corner in calibration.corners() {
        let column = ((corner.px.x + 0.5) / size.0 * cells.0 as f64).max(0.0) as usize;
        let row = ((corner.px.y + 0.5) / size.1 * cells.1 as f64).max(0.0) as usize;
        counts[row.min(cells.1 - 1) * cells.0 + column.min(cells.0 - 1)] += 1;
    }
    counts
}

fn extents(calibration: &Calibration, diagonal: f64) -> (f64, f64) {
    let extent = |view: &View| {
        let first = view.corners.first().map_or(nalgebra::Point2::origin(), |c| c.px);
        let (low, high) =
            view.corners.iter().fold((first, first), |(low, high), c| (low.inf(&c.px), high.sup(&c.px)));
        (high - low).norm() / diagonal
    };
    let shares = calibration.views.iter().map(extent);
    shares.fold((f64::INFINITY, 0.0), |(low, high), share| (low.min(share), high.max(share)))
}

/// Counts the views with each side nearer.
fn tilted(views: &[View]) -> [usize; 4] {
    let mut counts = [0; 4];
    for view in views {
        // Depth along the board's plane grows by -n.x / n.z for each meter to the right, where n is its normal.
        let n = view.camera_from_board.rotation().column(2).into_owned();
        let (right, down) = ((-n.x / n.z).atan(), (-n.y / n.z).atan());
        for (side, farther_there) in [(0, right), (1, -right), (2, down), (3, -down)] {
            counts[side] += usize::from(farther_there > TILTED_RAD);
        }
    }
    counts
}

fn advice(
    calibration: &Calibration,
    size: (f64, f64),
    tilted: &[usize; 4],
    extents: (f64, f64),
) -> Vec<Advice> {
    let mut advice = Vec::new();
    // The outer cells count: distortion is largest there.
    let fine = counts(calibration, size, (9, 9));
    for (column, row) in [(0, 0), (2, 0), (0, 2), (2, 2), (1, 0), (1, 2), (0, 1), (2, 1), (1, 1)] {
        let inside = |i: usize| i % 9 / 3 == column && i / 9 / 3 == row;
        let covered = (0..81).filter(|i| inside(*i) && fine[*i] > 0).count();
        if covered < 5 {
            advice.push(Advice::Region(column, row));
        }
    }
    advice.extend((0..4).filter(|side| tilted[*side] == 0).map(Advice::Tilt));
    if extents.1 < NEAR {
        advice.push(Advice::Nearer);
    }
    if extents.0 > FAR.max(0.7 * extents.1) {
        advice.push(Advice::Farther);
    }
    if calibration.views.len() < GOOD_VIEWS {
        advice.push(Advice::MoreViews(GOOD_VIEWS - calibration.views.len()));
    }
    advice
}
