//! Where a robot may walk.

use std::f64::consts::PI;

use nalgebra::Point2;
use rand::RngExt as _;
use visloc_core::{Rng, geom::PlanarPose};
use visloc_world::office::FreeSpace;

/// A rectangle around the origin, or the floor of a building, with round obstacles.
#[derive(Debug, Clone)]
pub(crate) struct Floor {
    /// Half sizes along x and y, meters.
    half_m: (f64, f64),
    /// What of the rectangle is floor; all of it if absent.
    building: Option<FreeSpace>,
    /// Middle and radius of what the robot's center must not come near to, meters.
    obstacles: Vec<(Point2<f64>, f64)>,
}

impl Floor {
    pub(crate) fn new(half_m: (f64, f64)) -> Self {
        Self { half_m, building: None, obstacles: Vec::new() }
    }

    /// The floor of a building.
    pub(crate) fn of_building(building: FreeSpace) -> Self {
        let [min, max] = building.bounds_m();
        let half = |low: f64, high: f64| low.abs().max(high.abs());
        Self { building: Some(building), ..Self::new((half(min.x, max.x), half(min.y, max.y))) }
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
            && self.building.as_ref().is_none_or(|building| has_margin(building, point, margin_m))
            && self.obstacles.iter().all(|(middle, radius)| (point - middle).norm() >= radius + margin_m)
    }

    /// Whether the straight way between two points is free.
    pub(crate) fn is_way_free(&self, from: &Point2<f64>, to: &Point2<f64>, margin_m: f64) -> bool {
        (0..=20).all(|i| self.is_free(&(from + (to - from) * (f64::from(i) / 20.0)), margin_m))
    }

    /// A random point to walk to from here: in a building one that is not far away, elsewhere any.
    pub(crate) fn random_point_from(&self, here: &Point2<f64>, rng: &mut Rng) -> Point2<f64> {
        const REACH_M: f64 = 3.0;
        if self.building.is_none() {
            return self.random_point(rng);
        }
        let mut step = || rng.random_range(-REACH_M..=REACH_M);
        Point2::new(here.x + step(), here.y + step())
    }

    /// A uniformly random point of the floor, free of obstacles or not.
    pub(crate) fn random_point(&self, rng: &mut Rng) -> Point2<f64> {
        if let Some(building) = &self.building {
            let in_cell = [rng.random_range(0.0..1.0), rng.random_range(0.0..1.0)];
            return building.place(rng.random_range(0.0..1.0), in_cell).unwrap_or_default();
        }
        let (x, y) = self.half_m;
        Point2::new(rng.random_range(-x..=x), rng.random_range(-y..=y))
    }

    /// A random free point; `None` if there seems to be none.
    pub(crate) fn random_free_point(&self, margin_m: f64, rng: &mut Rng) -> Option<Point2<f64>> {
        (0..500).map(|_| self.random_point(rng)).find(|point| self.is_free(point, margin_m))
    }

    /// A random free point with a random heading; `None` if there seems to be none.
    pub(crate) fn random_free_pose(&self, margin_m: f64, rng: &mut Rng) -> Option<PlanarPose> {
        let point = self.random_free_point(margin_m, rng)?;
        Some(PlanarPose::new(point.x, point.y, rng.random_range(-PI..PI)))
    }
}

/// Whether there is floor all around a point.
fn has_margin(building: &FreeSpace, point: &Point2<f64>, margin_m: f64) -> bool {
    let around = [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
    around.iter().all(|(x, y)| building.contains(point.x + x * margin_m, point.y + y * margin_m))
}
