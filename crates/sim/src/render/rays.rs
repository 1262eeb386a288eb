//! Directions of all pixels of a camera.

use std::ops::Range;

use nalgebra::Point2;
use visloc_core::geom::Camera;

/// The ray of every pixel as its point on the plane z = 1 of the camera frame.
#[derive(Debug)]
pub(crate) struct Rays {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    /// Step of the rays from one pixel to the next, on the axis.
    pub(crate) pitch: (f32, f32),
    columns: Bounds,
    rows: Bounds,
}

/// Ranges of one coordinate over rows or columns, widened so that both ends grow along the image. So a binary search
/// finds all rows that a range may touch, however the lens bends them.
#[derive(Debug)]
struct Bounds {
    low: Vec<f32>,
    high: Vec<f32>,
}

impl Bounds {
    fn new(mut low: Vec<f32>, mut high: Vec<f32>) -> Self {
        for i in 1..high.len() {
            high[i] = high[i].max(high[i - 1]);
            let back = low.len() - 1 - i;
            low[back] = low[back].min(low[back + 1]);
        }
        Self { low, high }
    }

    fn touched_by(&self, (from, to): (f32, f32)) -> Range<usize> {
        let start = self.high.partition_point(|high| *high < from);
        let end = self.low.partition_point(|low| *low <= to);
        start..end.max(start)
    }
}

impl Rays {
    pub(crate) fn new(camera: &Camera) -> Self {
        let (width, height) = (camera.size_px().0 as usize, camera.size_px().1 as usize);
        let (mut x, mut y) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
        let mut column_range = vec![(f32::INFINITY, f32::NEG_INFINITY); width];
        let mut row_range = vec![(f32::INFINITY, f32::NEG_INFINITY); height];
        for (v, row) in row_range.iter_mut().enumerate() {
            for (u, column) in column_range.iter_mut().enumerate() {
                let normalized = camera.normalized(&Point2::new(u as f64, v as f64));
                let (ray_x, ray_y) = (normalized.x as f32, normalized.y as f32);
                *column = (column.0.min(ray_x), column.1.max(ray_x));
                *row = (row.0.min(ray_y), row.1.max(ray_y));
                x.push(ray_x);
                y.push(ray_y);
            }
        }
        let bounds = |ranges: &[(f32, f32)]| {
            Bounds::new(ranges.iter().map(|r| r.0).collect(), ranges.iter().map(|r| r.1).collect())
        };
        let pitch = ((1.0 / camera.focal_px().0) as f32, (1.0 / camera.focal_px().1) as f32);
        Self { width, height, x, y, pitch, columns: bounds(&column_range), rows: bounds(&row_range) }
    }

    /// Columns and rows whose rays may fall into a rectangle of the plane z = 1, with one pixel around.
    pub(crate) fn touched_by(&self, x: (f32, f32), y: (f32, f32)) -> (Range<usize>, Range<usize>) {
        let columns = self.columns.touched_by((x.0 - self.pitch.0, x.1 + self.pitch.0));
        let rows = self.rows.touched_by((y.0 - self.pitch.1, y.1 + self.pitch.1));
        (columns, rows)
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::Distortion;

    use super::*;

    #[test]
    fn touched_pixels_contain_every_ray_in_the_rectangle() {
        let lens = Distortion::RadialTangential([-0.28, 0.05, 1e-3, -2e-3, 0.0]);
        let camera = Camera::new((80, 60), (60.0, 60.0), (39.5, 29.5), lens).unwrap();
        let rays = Rays::new(&camera);
        let (x, y) = ((-0.31, 0.12), (0.05, 0.4));
        let (columns, rows) = rays.touched_by(x, y);
        for v in 0..60 {
            for u in 0..80 {
                let i = v * 80 + u;
                let is_inside = (x.0..=x.1).contains(&rays.x[i]) && (y.0..=y.1).contains(&rays.y[i]);
                assert!(!is_inside || (columns.contains(&u) && rows.contains(&v)), "{u} {v}");
            }
        }
        assert!(columns.len() < 60 && rows.len() < 45);
    }
}
