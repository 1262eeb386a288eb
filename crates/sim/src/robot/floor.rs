//! Where a robot may walk.

use nalgebra::Point2;
use rand::RngExt as _;
use visloc_base::Rng;

/// A rectangle around the origin with round obstacles.
#[derive(Debug, Clone)]
pub(crate) struct Floor {
    /// Half sizes along x and y, meters.
    half_m: (f64, f64),
    /// Middle and radius of what the robot's center must not come near to, meters.
    obstacles: Vec<(Point2<f64>, f64)>,
}

impl Floor {
    pub(crate) fn new(half_m: (f64, f64)) -> Self {
        Self { half_m, obstacles: Vec::new() }
    }

    pub(crate) fn add_obstacle(&mut self, middle: Point2<f64>, radius_m: f64) {
        self.obstacles.push((middle, radius_m));
    }

    pub(crate) fn half_m(&self) -> (f64, f64) {
        self.half_m
    }

    /// Whether a robot may stand at a point with `margin_m` to spare.
    pub(crate) fn is_free(&self, point: &Point2<f64>, margin_m: f64) -> bool {
        point.x.abs() <= self.half_m.0 - margin_m
            && point.y.abs() <= self.half_m.1 - margin_m
            && self.obstacles.iter().all(|(middle, radius)| (point - middle).norm() >= radius + margin_m)
    }

    /// Whether the straight way between two points is free.
    pub(crate) fn is_way_free(&self, from: &Point2<f64>, to: &Point2<f64>, margin_m: f64) -> bool {
        (0..=20).all(|i| self.is_free(&(from + (to - from) * (f64::from(i) / 20.0)), margin_m))
    }

    /// A uniformly random point of the rectangle, free or not.
    pub(crate) fn random_point(&self, rng: &mut Rng) -> Point2<f64> {
        let (x, y) = self.half_m;
        Point2::new(rng.random_range(-x..=x), rng.random_range(-y..=y))
    }

    /// A random free point; `None` if there seems to be none.
    pub(crate) fn random_free_point(&self, margin_m: f64, rng: &mut Rng) -> Option<Point2<f64>> {
        (0..500).map(|_| self.random_point(rng)).find(|point| self.is_free(point, margin_m))
    }
}
