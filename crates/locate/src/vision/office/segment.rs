//! A straight edge, with what is needed to join it with others exactly.

use nalgebra::{Point2, Vector2};

use crate::vision::line_fit::LineFit;

/// A straight edge of the image, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeSegment {
    /// One end.
    pub start: Point2<f64>,
    /// The other end.
    pub end: Point2<f64>,
    fit: LineFit,
}

impl EdgeSegment {
    /// The line through the points of a fit, from the first to the last of two points that are near it.
    pub(super) fn fitted(fit: LineFit, ends: [Point2<f64>; 2]) -> Self {
        let line = fit.line();
        let [start, end] = ends.map(|point| line.at(line.position(&point)));
        Self { start, end, fit }
    }

    /// The part between two shares of its length, 0 to 1.
    pub(super) fn part(&self, from: f64, to: f64) -> Self {
        if from <= 0.0 && to >= 1.0 {
            return *self;
        }
        let along = self.end - self.start;
        let (start, end) = (self.start + along * from, self.start + along * to);
        let num_points = (end - start).norm().ceil().max(1.0);
        let mut fit = LineFit::default();
        let mut i = 0.0;
        while i <= num_points {
            fit.add(&(start + (end - start) * (i / num_points)));
            i += 1.0;
        }
        Self { start, end, fit }
    }

    /// Both edges as one.
    pub(super) fn joined(&self, other: &Self) -> Self {
        let fit = self.fit.joined(&other.fit);
        let along = self.direction();
        let ends = [self.start, self.end, other.start, other.end];
        let place = |point: &Point2<f64>| (point - self.start).dot(&along);
        let (mut first, mut last) = (self.start, self.end);
        for end in ends {
            if place(&end) < place(&first) {
                first = end;
            }
            if place(&end) > place(&last) {
                last = end;
            }
        }
        Self::fitted(fit, [first, last])
    }

    /// Length, pixels.
    pub fn length_px(&self) -> f64 {
        (self.end - self.start).norm()
    }

    /// Unit vector from start to end; along x for a segment without length.
    pub fn direction(&self) -> Vector2<f64> {
        (self.end - self.start).try_normalize(1e-9).unwrap_or_else(Vector2::x)
    }

    /// Distance of a point from the line through the segment, pixels.
    pub fn offset_px(&self, point: &Point2<f64>) -> f64 {
        self.direction().perp(&(point - self.start)).abs()
    }
}
