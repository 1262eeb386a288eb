//! Saddle points by place.

use nalgebra::Point2;

use super::Saddle;

/// Side of a bucket, pixels.
const BUCKET_PX: f64 = 16.0;

/// Finds the saddle points around a place.
#[derive(Debug)]
pub struct SaddleIndex {
    places: Vec<Point2<f64>>,
    buckets: Vec<Vec<usize>>,
    columns: usize,
    rows: usize,
}

impl SaddleIndex {
    /// Of saddle points in an image of a size, pixels.
    pub fn new(saddles: &[Saddle], width: usize, height: usize) -> Self {
        let (columns, rows) = (width / 16 + 1, height / 16 + 1);
        let mut index = Self {
            places: saddles.iter().map(|s| s.px).collect(),
            buckets: vec![Vec::new(); columns * rows],
            columns,
            rows,
        };
        for (i, saddle) in saddles.iter().enumerate() {
            let (x, y) = index.bucket(&saddle.px);
            index.buckets[y * columns + x].push(i);
        }
        index
    }

    fn bucket(&self, px: &Point2<f64>) -> (usize, usize) {
        let at = |v: f64, count: usize| ((v / BUCKET_PX).max(0.0) as usize).min(count - 1);
        (at(px.x, self.columns), at(px.y, self.rows))
    }

    /// Numbers of all saddle points within a radius, pixels.
    pub fn within(&self, px: &Point2<f64>, radius_px: f64) -> impl Iterator<Item = usize> {
        let offset = nalgebra::Vector2::repeat(radius_px);
        let (first, last) = (self.bucket(&(px - offset)), self.bucket(&(px + offset)));
        let buckets = (first.1..=last.1).flat_map(move |y| (first.0..=last.0).map(move |x| (x, y)));
        let px = *px;
        buckets
            .flat_map(move |(x, y)| self.buckets[y * self.columns + x].iter().copied())
            .filter(move |i| (self.places[*i] - px).norm() <= radius_px)
    }
}
