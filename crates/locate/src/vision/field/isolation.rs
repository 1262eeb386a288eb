//! Thin lines among specks: a line goes on.

use super::{edges::Edge, scan::Direction};

/// Runs from this length on are no specks: noise of single pixels and of the colors of a JPEG is smaller.
const MIN_THICK_PX: u32 = 3;
/// A thin line is followed so far to both sides of a scan line, pixels: farther than a speck reaches.
const REACH_PX: i64 = 3;

/// Whether white goes on to both sides of a scan line, opposite to each other, if the run is so thin that it may be a speck. What a thin
/// line crosses at less than 45 degrees the other scan lines cross better.
pub(super) fn goes_on(edge: &Edge, (width, height): (u32, u32), is_white: impl Fn(u32, u32) -> bool) -> bool {
    if edge.run_px >= MIN_THICK_PX {
        return true;
    }
    let (x, y) = (i64::from(edge.inside_px.0), i64::from(edge.inside_px.1));
    let at = |across: i64, along: i64| {
        let (dx, dy) = match edge.direction {
            Direction::Horizontal => (along, across),
            Direction::Vertical => (across, along),
        };
        let x = u32::try_from(x + dx).ok().filter(|x| *x < width)?;
        let y = u32::try_from(y + dy).ok().filter(|y| *y < height)?;
        Some(is_white(x, y))
    };
    // Beyond the image nothing contradicts.
    (-REACH_PX..=REACH_PX).any(|slope| {
        let is_on_side = |side: i64| {
            [0, -1, 1].into_iter().any(|off| at(side * REACH_PX, side * slope + off) != Some(false))
        };
        is_on_side(1) && is_on_side(-1)
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::vision::FeatureKind;

    fn edge(direction: Direction, run_px: u32) -> Edge {
        Edge {
            px: Point2::new(20.0, 19.5),
            inside_px: (20, 20),
            is_start: true,
            kind: FeatureKind::FieldLine,
            white_luma: 110,
            is_beside_carpet: true,
            run_px,
            direction,
            is_upright: false,
        }
    }

    #[test]
    fn lines_go_on_and_specks_do_not() {
        let size = (40, 40);
        let slanted = |x: u32, y: u32| x / 2 + 10 == y;
        let speck = |x: u32, y: u32| x.abs_diff(20) < 2 && y.abs_diff(20) < 2;
        let end = |x: u32, y: u32| y == 20 && x <= 20;
        let vertical = edge(Direction::Vertical, 2);
        assert!(goes_on(&vertical, size, slanted));
        assert!(!goes_on(&vertical, size, speck) && !goes_on(&vertical, size, end));
        let horizontal = edge(Direction::Horizontal, 1);
        assert!(goes_on(&horizontal, size, |x, y| slanted(y, x)));
        assert!(!goes_on(&horizontal, size, speck));
        // A thick run is no speck.
        assert!(goes_on(&edge(Direction::Vertical, 3), size, speck));
    }
}
