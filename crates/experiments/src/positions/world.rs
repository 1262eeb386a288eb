//! The observation model of the synthetic world.

use std::sync::Arc;

use rand::RngExt;
use visloc_core::{Rng, geom::PlanarPose};
use visloc_locate::{ObservationModel, Region, vision::Percept};

use super::scenario::{HALF_SIDE_M, Scenario};

/// Every position looks the same: the likelihood of a pose is `floor + (1 - floor) exp(-d^2 / 2)`, d its distance to
/// the nearest position in meters. The heading does not matter. Source: 2017 section 5.1, figure 5.1, with floor 0.
///
/// A percept's stamp counts the iterations, one a second.
#[derive(Debug, Clone)]
pub struct PositionsWorld {
    scenario: Arc<Scenario>,
    floor: f64,
    iteration: usize,
}

impl PositionsWorld {
    /// The world of a scenario at its first iteration.
    pub fn new(scenario: Arc<Scenario>, floor: f64) -> Self {
        Self { scenario, floor, iteration: 0 }
    }

    /// Square of the distance to the nearest position, square meters.
    #[inline]
    fn nearest_squared_m2(&self, pose: &PlanarPose) -> f64 {
        let squared_m2 = |p: &[f64; 2]| (p[0] - pose.x_m).powi(2) + (p[1] - pose.y_m).powi(2);
        let positions = self.scenario.positions(self.iteration).iter();
        positions.map(squared_m2).fold(f64::INFINITY, f64::min)
    }
}

impl ObservationModel for PositionsWorld {
    fn condition_on(&mut self, percept: &Percept) {
        self.iteration = percept.at.secs().round().max(0.0) as usize;
    }

    fn has_evidence(&self) -> bool {
        true
    }

    #[inline]
    fn likelihood(&self, world_from_robot: &PlanarPose) -> f64 {
        self.floor + (1.0 - self.floor) * (-0.5 * self.nearest_squared_m2(world_from_robot)).exp()
    }

    /// Without a floor the logarithm needs no exponential.
    #[inline]
    fn log_likelihood(&self, world_from_robot: &PlanarPose) -> f64 {
        if self.floor == 0.0 {
            -0.5 * self.nearest_squared_m2(world_from_robot)
        } else {
            self.likelihood(world_from_robot).ln()
        }
    }

    fn region(&self) -> Region {
        Region { min_x_m: -HALF_SIDE_M, max_x_m: HALF_SIDE_M, min_y_m: -HALF_SIDE_M, max_y_m: HALF_SIDE_M }
    }

    fn max_jump_m(&self) -> f64 {
        2.0
    }

    fn propose(&self, rng: &mut Rng) -> PlanarPose {
        self.region().sample(rng)
    }

    fn propose_heading(&self, _x_m: f64, _y_m: f64, rng: &mut Rng) -> f64 {
        rng.random_range(-std::f64::consts::PI..std::f64::consts::PI)
    }
}
