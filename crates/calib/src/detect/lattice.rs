//! From a grid of saddle points to the numbered corners of a checkerboard.

use nalgebra::Point2;

use super::{
    DetectReject,
    grow::{Cell, Grid},
};
use crate::{
    Checkerboard,
    saddles::{FloatImage, Saddle},
};

/// A grid laid on the board.
type Numbered = Vec<(usize, Point2<f64>)>;

/// Numbers the corners of a grid, if it has the size of the board.
pub(super) fn number(
    grid: &Grid,
    saddles: &[Saddle],
    image: &FloatImage,
    board: &Checkerboard,
) -> Result<Numbered, DetectReject> {
    let (columns, rows) = (board.columns as i32, board.rows as i32);
    let (low, high) = bounds(grid);
    let (width, height) = (high.0 - low.0 + 1, high.1 - low.1 + 1);
    let best = best_window(grid, board, (low, high)).map(|window| {
        let inside = grid.keys().filter(|cell| window.contains(**cell)).count();
        (inside, turned(grid, saddles, &window, (columns, rows)))
    });
    let Some((count, layouts)) = best else {
        let side = |v: i32| usize::try_from(v).unwrap_or(0);
        return Err(DetectReject::OtherSize {
            expected_columns: board.columns,
            expected_rows: board.rows,
            columns: side(width.max(height)),
            rows: side(width.min(height)),
        });
    };
    if 2 * count < board.columns * board.rows {
        return Err(DetectReject::Covered { expected: board.columns * board.rows, found: count });
    }
    let key = |layout: &Numbered| (!starts_black(layout, image, board.columns), origin_key(layout));
    layouts.into_iter().min_by_key(key).ok_or(DetectReject::NoBoard(saddles.len()))
}

/// A part of a grid.
#[derive(Debug, Clone, Copy)]
struct Window {
    first: Cell,
    size: (i32, i32),
}

impl Window {
    fn contains(&self, (i, j): Cell) -> bool {
        (0..self.size.0).contains(&(i - self.first.0)) && (0..self.size.1).contains(&(j - self.first.1))
    }
}

/// The part of the grid with the board's size and the most corners, if one can be the board.
fn best_window(grid: &Grid, board: &Checkerboard, (low, high): (Cell, Cell)) -> Option<Window> {
    let (columns, rows) = (board.columns as i32, board.rows as i32);
    let whole = (high.0 - low.0 + 1, high.1 - low.1 + 1);
    let mut best: Option<(usize, Window)> = None;
    for size in [(columns, rows), (rows, columns)] {
        let firsts =
            (low.0..=high.0 + 1 - size.0).flat_map(|i| (low.1..=high.1 + 1 - size.1).map(move |j| (i, j)));
        for first in firsts {
            let window = Window { first, size };
            let inside = grid.keys().filter(|cell| window.contains(**cell)).count();
            // A window within a larger grid must be full, else the place of the board in it is a guess; and beyond it there
            // may be some clutter, but no further row, else it is another board.
            let is_alone = 2 * (grid.len() - inside) < board.columns.min(board.rows);
            let is_possible = whole == size || (inside == board.columns * board.rows && is_alone);
            if is_possible && best.is_none_or(|(count, _)| inside > count) {
                best = Some((inside, window));
            }
        }
    }
    best.map(|(_, window)| window)
}

fn bounds(grid: &Grid) -> (Cell, Cell) {
    grid.keys().fold(((i32::MAX, i32::MAX), (i32::MIN, i32::MIN)), |(low, high), c| {
        ((low.0.min(c.0), low.1.min(c.1)), (high.0.max(c.0), high.1.max(c.1)))
    })
}

/// The window's corners with the board's numbers, in every way of turning the board that is not mirrored.
fn turned(grid: &Grid, saddles: &[Saddle], window: &Window, (columns, rows): (i32, i32)) -> Vec<Numbered> {
    let Window { first, size: (size_i, size_j) } = *window;
    let mut layouts = Vec::new();
    for mirror in [false, true] {
        for quarters in 0..4 {
            let place = |cell: &Cell| {
                let (mut i, mut j) = (cell.0 - first.0, cell.1 - first.1);
                let (mut w, mut h) = (size_i, size_j);
                if mirror {
                    (i, j, w, h) = (j, i, h, w);
                }
                for _ in 0..quarters {
                    (i, j, w, h) = (h - 1 - j, i, h, w);
                }
                ((w, h) == (columns, rows) && (0..w).contains(&i) && (0..h).contains(&j)).then_some((i, j))
            };
            let mut layout: Numbered = grid
                .iter()
                .filter_map(|(cell, saddle)| {
                    let (i, j) = place(cell)?;
                    Some((usize::try_from(j * columns + i).ok()?, saddles[*saddle].px))
                })
                .collect();
            layout.sort_by_key(|(id, _)| *id);
            if is_right_handed(&layout, columns as usize) {
                layouts.push(layout);
            }
        }
    }
    layouts
}

/// Three corners of a square: the first, along x, along y.
fn squares(layout: &Numbered, columns: usize) -> impl Iterator<Item = (usize, [Point2<f64>; 3])> {
    let find = move |id: usize| layout.binary_search_by_key(&id, |c| c.0).ok().map(|i| layout[i].1);
    layout.iter().filter_map(move |(id, px)| {
        let right = (id % columns + 1 < columns).then(|| find(id + 1)).flatten()?;
        Some((*id, [*px, right, find(id + columns)?]))
    })
}

/// Whether y is clockwise of x in the image, as seen on the front of a board.
fn is_right_handed(layout: &Numbered, columns: usize) -> bool {
    let area: f64 = squares(layout, columns).map(|(_, [o, x, y])| (x - o).perp(&(y - o))).sum();
    area > 0.0
}

/// Whether the square before the first corner is black; that is the color of the square at it.
fn starts_black(layout: &Numbered, image: &FloatImage, columns: usize) -> bool {
    let mut brighter = 0.0;
    for (id, [o, x, y]) in squares(layout, columns) {
        // Squares with an even sum of their places are black: (0, 0) touches the one before the origin at its corner.
        let is_even = (id % columns + id / columns).is_multiple_of(2);
        let center = nalgebra::center(&x, &y);
        let beside = o + (o - x) * 0.5 + (y - o) * 0.5;
        let difference = image.sample(&center) - image.sample(&beside);
        brighter += if is_even { difference } else { -difference };
    }
    brighter < 0.0
}

/// Of layouts that are equally good, the one whose first corner is nearest to the upper left of the image.
fn origin_key(layout: &Numbered) -> i64 {
    layout.first().map_or(i64::MAX, |(_, px)| ((px.x + px.y) * 16.0) as i64)
}
