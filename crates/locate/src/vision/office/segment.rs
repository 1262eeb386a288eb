//! A straight edge, with what is needed to join it with others exactly.

use nalgebra::{Point2, Vector2};

/// A straight edge of the image, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeSegment {
    /// One end.
    pub start: Point2<f64>,
    /// The other end.
    pub end: Point2<f64>,
    moments: Moments,
}

/// Sums over the points of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Moments {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Moments {
    #[inline]
    pub fn add(&mut self, point: Point2<f64>) {
        self.count += 1.0;
        self.x += point.x;
        self.y += point.y;
        self.xx += point.x * point.x;
        self.xy += point.x * point.y;
        self.yy += point.y * point.y;
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            x: self.x + other.x,
            y: self.y + other.y,
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            yy: self.yy + other.yy,
        }
    }

    /// Middle of the points, the direction in which they spread most, and their mean square distance from that line.
    pub fn line(&self) -> (Point2<f64>, Vector2<f64>, f64) {
        let n = self.count.max(1.0);
        let (x, y) = (self.x / n, self.y / n);
        let (xx, xy, yy) = (self.xx / n - x * x, self.xy / n - x * y, self.yy / n - y * y);
        let spread = ((xx - yy) * 0.5).hypot(xy);
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sin, cos) = angle.sin_cos();
        (Point2::new(x, y), Vector2::new(cos, sin), ((xx + yy) * 0.5 - spread).max(0.0))
    }
}

impl EdgeSegment {
    /// The line through points with the given sums, from the first to the last of two points that are near it.
    pub(super) fn fitted(moments: Moments, ends: [Point2<f64>; 2]) -> Self {
        let (middle, along, _) = moments.line();
        let onto = |point: Point2<f64>| middle + along * (point - middle).dot(&along);
        Self { start: onto(ends[0]), end: onto(ends[1]), moments }
    }

    /// The part between two shares of its length, 0 to 1.
    pub(super) fn part(&self, from: f64, to: f64) -> Self {
        if from <= 0.0 && to >= 1.0 {
            return *self;
        }
        let along = self.end - self.start;
        let (start, end) = (self.start + along * from, self.start + along * to);
        let num_points = (end - start).norm().ceil().max(1.0);
        let mut moments = Moments::default();
        let mut i = 0.0;
        while i <= num_points {
            moments.add(start + (end - start) * (i / num_points));
            i += 1.0;
        }
        Self { start, end, moments }
    }

    /// Both edges as one.
    pub(super) fn joined(&self, other: &Self) -> Self {
        let moments = self.moments.plus(&other.moments);
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
        Self::fitted(moments, [first, last])
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
