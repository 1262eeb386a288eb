//! A straight line through pixels, by total least squares from running sums.

use nalgebra::{Point2, Vector2};

/// Sums over pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LineFit {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

/// A straight line in the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImageLine {
    pub point: Point2<f64>,
    /// Unit vector.
    pub along: Vector2<f64>,
    /// Root of the mean squared distance of the pixels, pixels.
    pub rms_px: f64,
}

impl LineFit {
    #[inline]
    pub fn add(&mut self, p: &Point2<f64>) {
        self.n += 1.0;
        self.x += p.x;
        self.y += p.y;
        self.xx += p.x * p.x;
        self.xy += p.x * p.y;
        self.yy += p.y * p.y;
    }

    /// The fit through the pixels of both.
    pub fn joined(&self, other: &Self) -> Self {
        Self {
            n: self.n + other.n,
            x: self.x + other.x,
            y: self.y + other.y,
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            yy: self.yy + other.yy,
        }
    }

    /// The line; of a single pixel any line through it.
    pub fn line(&self) -> ImageLine {
        let point = Point2::new(self.x / self.n, self.y / self.n);
        let xx = self.xx / self.n - point.x * point.x;
        let xy = self.xy / self.n - point.x * point.y;
        let yy = self.yy / self.n - point.y * point.y;
        let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
        let across2 = xx * sin * sin - 2.0 * xy * sin * cos + yy * cos * cos;
        ImageLine { point, along: Vector2::new(cos, sin), rms_px: across2.max(0.0).sqrt() }
    }
}

impl ImageLine {
    /// Position of a pixel along the line, pixels.
    pub fn position(&self, p: &Point2<f64>) -> f64 {
        (p - self.point).dot(&self.along)
    }

    /// Distance of a pixel from the line, pixels.
    pub fn distance(&self, p: &Point2<f64>) -> f64 {
        self.along.perp(&(p - self.point)).abs()
    }

    /// The pixel at a position along the line.
    pub fn at(&self, position: f64) -> Point2<f64> {
        self.point + self.along * position
    }

    /// Unit vector across the line.
    pub fn across(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }

    /// Where two lines cross; `None` if they are parallel.
    pub fn crossing(&self, other: &Self) -> Option<Point2<f64>> {
        let turn = self.along.perp(&other.along);
        let t = (other.point - self.point).perp(&other.along) / turn;
        (turn.abs() > 1e-3).then(|| self.at(t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_any_direction_is_found() {
        for degrees in (0..180).step_by(15) {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let mut fit = LineFit::default();
            for i in -5..=5 {
                let (t, off) = (f64::from(i) * 3.0, if i % 2 == 0 { 0.1 } else { -0.1 });
                fit.add(&Point2::new(100.0 + cos * t - sin * off, 50.0 + sin * t + cos * off));
            }
            let line = fit.line();
            assert!(line.along.perp(&Vector2::new(cos, sin)).abs() < 0.01, "{degrees}");
            assert!((line.rms_px - 0.1).abs() < 0.01 && line.distance(&Point2::new(100.0, 50.0)) < 0.05);
        }
    }

    #[test]
    fn crossing_by_hand() {
        let line = |point, along| ImageLine { point, along, rms_px: 0.0 };
        let a = line(Point2::new(0.0, 2.0), Vector2::x());
        let b = line(Point2::new(3.0, 0.0), Vector2::y());
        assert_eq!(a.crossing(&b), Some(Point2::new(3.0, 2.0)));
        assert_eq!(a.crossing(&a), None);
    }
}
