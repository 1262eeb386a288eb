//! How lines differ besides their color: each color of a series has a dash and a mark of its own, and the truth is dashed without a
//! mark, so that it can lie above estimates without hiding them.

use crate::{
    Color,
    svg::{Canvas, Paint, Point},
};

/// Way along a line from one mark to the next, and size of a mark, pixels.
const MARK_GAP_PX: f64 = 120.0;
const MARK_PX: f64 = 3.4;

/// Lengths of lines and gaps of the series, pixels as SVG writes them, in the order of [`Color::series`].
const DASHES: [Option<&str>; 6] =
    [None, Some("10 4"), Some("3 3"), Some("10 3 3 3"), Some("16 5"), Some("6 3 2 3 2 3")];
/// Of the truth.
const TRUTH: &str = "7 4";

fn dashes(color: Color) -> Option<&'static str> {
    match color.series_index() {
        // Darker ones have the mark of the lighter one, but another dash.
        Some(index) => DASHES[(index + index / DASHES.len()) % DASHES.len()],
        None if color == Color::BLACK => Some(TRUTH),
        None => None,
    }
}

/// Corners of the mark of a series around the origin, as far away as 1; a circle has none.
fn corners(index: usize) -> &'static [Point] {
    match index % DASHES.len() {
        0 => &[],
        1 => &[(-0.85, -0.85), (0.85, -0.85), (0.85, 0.85), (-0.85, 0.85)],
        2 => &[(0.0, -1.15), (1.0, 0.75), (-1.0, 0.75)],
        3 => &[(0.0, -1.2), (1.05, 0.0), (0.0, 1.2), (-1.05, 0.0)],
        4 => &[(0.0, 1.15), (1.0, -0.75), (-1.0, -0.75)],
        _ => &[(0.0, -1.1), (1.05, -0.35), (0.65, 0.9), (-0.65, 0.9), (-1.05, -0.35)],
    }
}

/// How a line of this color is painted.
pub(crate) fn stroke(color: Color, width_px: f64) -> Paint {
    let paint = Paint::stroke(color, width_px);
    dashes(color).map_or(paint, |dashes| paint.with_dashes(dashes))
}

/// The mark of a series; colors of no series have none.
pub(crate) fn draw_mark(canvas: &mut Canvas, color: Color, (x, y): Point) {
    let Some(index) = color.series_index() else { return };
    let paint = Paint::fill(color).outlined(Color::WHITE, 0.8);
    let outline: Vec<Point> =
        corners(index).iter().map(|(dx, dy)| (x + MARK_PX * dx, y + MARK_PX * dy)).collect();
    match outline[..] {
        [] => canvas.circle((x, y), MARK_PX, &paint),
        _ => canvas.polygon(&outline, &paint),
    }
}

/// Marks along a line, those of each series at other places.
pub(crate) fn draw_marks(canvas: &mut Canvas, color: Color, points: &[Point]) {
    let Some(index) = color.series_index() else { return };
    let mut left_px = MARK_GAP_PX * (0.25 + index as f64 / DASHES.len() as f64).fract();
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let length_px = (to.0 - from.0).hypot(to.1 - from.1);
        // One for each piece at most: a line of frames has short ones, a jump is none.
        if length_px >= left_px && length_px > 0.0 {
            let share = left_px / length_px;
            draw_mark(canvas, color, (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1)));
            left_px = MARK_GAP_PX;
        } else {
            left_px -= length_px;
        }
    }
}

/// Whether a line of this color lies above the others.
pub(crate) fn is_above(color: Color) -> bool {
    color == Color::BLACK
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_series_has_a_dash_and_a_mark_of_its_own() {
        let differ = |i: usize, j: usize| {
            [dashes(Color::series(i)) != dashes(Color::series(j)), corners(i) != corners(j)]
        };
        for i in 0..2 * DASHES.len() {
            for j in 0..i {
                let is_same_shade = i / DASHES.len() == j / DASHES.len();
                let [has_own_dash, has_own_mark] = differ(i, j);
                assert!(has_own_dash || (has_own_mark && !is_same_shade), "{i} and {j}");
                assert!(has_own_mark || !is_same_shade, "{i} and {j}");
            }
        }
        assert!(dashes(Color::BLACK).is_some(), "truth is dashed");
        assert_eq!(dashes(Color::GRAY), None);
    }

    #[test]
    fn marks_stand_along_a_line_and_not_where_it_is_short() {
        let num_marks = |points: &[Point]| {
            let mut canvas = Canvas::new(1000.0, 10.0);
            draw_marks(&mut canvas, Color::series(0), points);
            canvas.finish().svg().matches("<circle").count()
        };
        let line: Vec<Point> = (0..=600).map(|i| (f64::from(i), 0.0)).collect();
        assert_eq!(num_marks(&line), 5);
        assert_eq!(num_marks(&line[..20]), 0);
        assert_eq!(num_marks(&[]), 0);
    }
}
