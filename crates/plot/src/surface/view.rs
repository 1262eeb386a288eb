//! Parallel projection of a height field, and its cells from far to near.

use crate::{Grid, svg::Point};

/// Most cells along a side: more cannot be told apart and make large files.
const MAX_CELLS: usize = 80;

/// Heights at the corners of a regular mesh, 0 to 1.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    pub(super) origin_m: [f64; 2],
    pub(super) step_m: f64,
    pub(super) num_columns: usize,
    /// Rows along x, the first at the lowest y. Not a number is a hole.
    pub(super) heights: Vec<f64>,
}

impl Mesh {
    /// The middles of the cells of a grid, thinned out by maxima; `height` maps values to heights. `None` if fewer than
    /// two rows or columns are left.
    pub(super) fn new(grid: &Grid, height: impl Fn(f64) -> f64) -> Option<Self> {
        let columns = grid.num_columns.max(1);
        let rows = grid.values.len() / columns;
        let stride = columns.max(rows).div_ceil(MAX_CELLS);
        let (num_columns, num_rows) = (columns / stride, rows / stride);
        if num_columns < 2 || num_rows < 2 || !(grid.cell_m > 0.0 && grid.cell_m.is_finite()) {
            return None;
        }
        let block = |row: usize, column: usize| {
            let cells =
                (0..stride * stride).map(|i| (row * stride + i / stride, column * stride + i % stride));
            cells.map(|(r, c)| grid.values[r * columns + c]).fold(f64::NAN, f64::max)
        };
        let cells = (0..num_rows).flat_map(|row| (0..num_columns).map(move |column| (row, column)));
        let step_m = grid.cell_m * stride as f64;
        Some(Self {
            origin_m: grid.origin_m.map(|origin| origin + step_m / 2.0),
            step_m,
            num_columns,
            heights: cells.map(|(row, column)| height(block(row, column))).collect(),
        })
    }

    pub(super) fn num_rows(&self) -> usize {
        self.heights.len() / self.num_columns
    }

    pub(super) fn corner_m(&self, row: usize, column: usize) -> [f64; 3] {
        let x = self.origin_m[0] + column as f64 * self.step_m;
        let y = self.origin_m[1] + row as f64 * self.step_m;
        [x, y, self.heights[row * self.num_columns + column]]
    }

    /// The cell around a place and the height there, linear between the corners; `None` outside.
    pub(super) fn cell_at(&self, x_m: f64, y_m: f64) -> Option<((usize, usize), f64)> {
        let (u, v) = ((x_m - self.origin_m[0]) / self.step_m, (y_m - self.origin_m[1]) / self.step_m);
        let (most_u, most_v) = ((self.num_columns - 1) as f64, (self.num_rows() - 1) as f64);
        // A place half a cell outside of the outer corners still belongs to the grid.
        if !(-0.5..=most_u + 0.5).contains(&u) || !(-0.5..=most_v + 0.5).contains(&v) {
            return None;
        }
        let (u, v) = (u.clamp(0.0, most_u), v.clamp(0.0, most_v));
        let (column, row) = ((u as usize).min(self.num_columns - 2), (v as usize).min(self.num_rows() - 2));
        let (s, t) = (u - column as f64, v - row as f64);
        let height = |r: usize, c: usize| self.heights[(row + r) * self.num_columns + column + c];
        let low = height(0, 0) * (1.0 - s) + height(0, 1) * s;
        let high = height(1, 0) * (1.0 - s) + height(1, 1) * s;
        Some(((row, column), low * (1.0 - t) + high * t))
    }
}

/// Parallel projection onto the picture. Heights are drawn `relief_m` high.
#[derive(Debug, Clone, Copy)]
pub(super) struct ObliqueView {
    sin_azimuth: f64,
    cos_azimuth: f64,
    sin_elevation: f64,
    cos_elevation: f64,
    relief_m: f64,
    px_per_m: f64,
    offset_px: Point,
}

impl ObliqueView {
    /// Fits the box over the mesh into a width; its top left is at `corner_px`.
    pub(super) fn new(angles_deg: (f64, f64), mesh: &Mesh, width_px: f64, corner_px: Point) -> Self {
        let (azimuth, elevation) =
            (angles_deg.0.clamp(0.0, 90.0).to_radians(), angles_deg.1.clamp(0.0, 90.0).to_radians());
        let ends = [mesh.corner_m(0, 0), mesh.corner_m(mesh.num_rows() - 1, mesh.num_columns - 1)];
        let largest_m = (ends[1][0] - ends[0][0]).max(ends[1][1] - ends[0][1]);
        let mut view = Self {
            sin_azimuth: azimuth.sin(),
            cos_azimuth: azimuth.cos(),
            sin_elevation: elevation.sin(),
            cos_elevation: elevation.cos(),
            relief_m: 0.34 * largest_m,
            px_per_m: 1.0,
            offset_px: (0.0, 0.0),
        };
        let (left, top, right, _) = view.bounds(&ends);
        view.px_per_m = width_px / (right - left);
        view.offset_px = (corner_px.0 - left * view.px_per_m, corner_px.1 - top * view.px_per_m);
        view
    }

    /// Left, top, right and bottom of the box between two opposite corners of the ground, pixels.
    pub(super) fn bounds(&self, ends: &[[f64; 3]; 2]) -> (f64, f64, f64, f64) {
        let corners = (0..8).map(|i: usize| {
            self.px([ends[i & 1][0], ends[i >> 1 & 1][1], if i & 4 == 0 { 0.0 } else { 1.0 }])
        });
        corners.fold((f64::MAX, f64::MAX, f64::MIN, f64::MIN), |(l, t, r, b), (x, y)| {
            (l.min(x), t.min(y), r.max(x), b.max(y))
        })
    }

    /// Where a place (x and y in meters, height 0 to 1) is in the picture.
    pub(super) fn px(&self, [x, y, height]: [f64; 3]) -> Point {
        let right = x * self.cos_azimuth + y * self.sin_azimuth;
        let up = self.depth_m(x, y) * self.sin_elevation + height * self.relief_m * self.cos_elevation;
        (self.offset_px.0 + right * self.px_per_m, self.offset_px.1 - up * self.px_per_m)
    }

    /// How far away a place on the ground is, up to a constant, meters.
    pub(super) fn depth_m(&self, x: f64, y: f64) -> f64 {
        y * self.cos_azimuth - x * self.sin_azimuth
    }

    /// A way along the ground toward the viewer, meters.
    pub(super) fn toward_viewer(&self, way_m: f64) -> (f64, f64) {
        (way_m * self.sin_azimuth, -way_m * self.cos_azimuth)
    }

    /// All cells of a mesh (row and column of their first corner), the farthest first: drawn in this order, near cells
    /// cover what they hide.
    pub(super) fn cells_from_far(&self, mesh: &Mesh) -> Vec<(usize, usize)> {
        let (rows, columns) = (mesh.num_rows() - 1, mesh.num_columns - 1);
        let mut cells: Vec<_> = (0..rows).flat_map(|row| (0..columns).map(move |c| (row, c))).collect();
        let depth = |&(row, column): &(usize, usize)| {
            let [x, y, _] = mesh.corner_m(row, column);
            self.depth_m(x, y)
        };
        cells.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(num_columns: usize, values: Vec<f64>) -> Mesh {
        Mesh::new(&Grid { origin_m: [0.0, 0.0], cell_m: 1.0, num_columns, values }, |v| v).unwrap()
    }

    #[test]
    fn heights_are_linear_between_the_middles_of_the_cells() {
        let mesh = mesh(2, vec![0.0, 1.0, 0.5, 0.5]);
        assert_eq!(mesh.cell_at(1.0, 0.5), Some(((0, 0), 0.5)));
        assert_eq!(mesh.cell_at(1.5, 1.0), Some(((0, 0), 0.75)));
        assert_eq!(mesh.cell_at(0.1, 0.1), Some(((0, 0), 0.0)), "the outer half of the first cell");
        assert_eq!(mesh.cell_at(2.2, 0.5), None);
    }

    #[test]
    fn thinning_keeps_the_peak() {
        let mut values = vec![0.0; 200 * 200];
        values[57 * 200 + 133] = 0.9;
        let mesh = mesh(200, values);
        assert!(mesh.num_columns <= MAX_CELLS);
        assert_eq!(mesh.heights.iter().copied().fold(0.0, f64::max), 0.9);
    }

    #[test]
    fn far_cells_come_first_and_high_places_are_higher() {
        let mesh = mesh(3, vec![0.0; 9]);
        let view = ObliqueView::new((30.0, 40.0), &mesh, 100.0, (0.0, 0.0));
        let cells = view.cells_from_far(&mesh);
        assert_eq!((cells.first(), cells.last()), (Some(&(1, 0)), Some(&(0, 1))));
        assert!(view.px([1.0, 1.0, 1.0]).1 < view.px([1.0, 1.0, 0.0]).1);
        assert!(view.px([2.0, 1.0, 0.0]).0 > view.px([1.0, 1.0, 0.0]).0);
    }
}
