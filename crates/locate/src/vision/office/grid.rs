//! Pixels where lines cross a grid that is finer near the horizon.
//!
//! Source: 2017 section 5.3.1: far things are high in the image and small there.

use nalgebra::Point2;

use super::EdgeSegment;

/// A grid of cells that grow from the horizon down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// Row where the cells are smallest, pixels.
    pub first_row_px: f64,
    /// Row where they are largest, pixels.
    pub last_row_px: f64,
    /// Smallest and largest side of a cell, pixels.
    pub cell_px: [f64; 2],
}

impl Grid {
    fn cell_at(&self, row_px: f64) -> f64 {
        let t =
            ((row_px - self.first_row_px) / (self.last_row_px - self.first_row_px).max(1.0)).clamp(0.0, 1.0);
        self.cell_px[0] + t * (self.cell_px[1] - self.cell_px[0])
    }

    /// Visits the pixels where a segment crosses the lines of the grid. The first crossing lies half a cell behind the
    /// segment's upper end, so that no line of the grid has to be stored.
    pub fn crossings(&self, segment: &EdgeSegment, mut visit: impl FnMut(Point2<f64>)) {
        let (top, bottom) = if segment.start.y <= segment.end.y {
            (segment.start, segment.end)
        } else {
            (segment.end, segment.start)
        };
        let length_px = segment.length_px();
        let along = (bottom - top) / length_px.max(1e-9);
        // A line crosses rows or columns of the grid, whichever it crosses more often.
        let steepness = along.x.abs().max(along.y.abs()).max(1e-9);
        let mut s = 0.5 * self.cell_at(top.y) / steepness;
        while s < length_px {
            let at = top + along * s;
            visit(at);
            s += self.cell_at(at.y) / steepness;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::line_fit::LineFit;

    #[test]
    fn far_parts_of_a_line_give_more_pixels() {
        let grid = Grid { first_row_px: 80.0, last_row_px: 240.0, cell_px: [4.0, 16.0] };
        let ends = [Point2::new(100.0, 80.0), Point2::new(100.0, 239.0)];
        let mut fit = LineFit::default();
        ends.iter().for_each(|end| fit.add(end));
        let mut rows = Vec::new();
        grid.crossings(&EdgeSegment::fitted(fit, ends), |px| rows.push(px.y));
        let upper = rows.iter().filter(|row| **row < 160.0).count();
        assert!(upper * 10 > 6 * rows.len(), "{rows:?}");
        assert!(rows.windows(2).all(|pair| pair[1] - pair[0] >= 4.0 - 1e-9));
    }
}
