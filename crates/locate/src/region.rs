//! Where a robot can be.

use rand::RngExt;
use serde::{Deserialize, Serialize};
use visloc_core::{Rng, geom::PlanarPose};

/// A rectangle of the map, meters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Least x.
    pub min_x_m: f64,
    /// Largest x.
    pub max_x_m: f64,
    /// Least y.
    pub min_y_m: f64,
    /// Largest y.
    pub max_y_m: f64,
}

impl Region {
    /// Whether a pose is inside.
    #[inline]
    pub fn contains(&self, pose: &PlanarPose) -> bool {
        (self.min_x_m..=self.max_x_m).contains(&pose.x_m) && (self.min_y_m..=self.max_y_m).contains(&pose.y_m)
    }

    /// A pose anywhere inside with any heading.
    pub fn sample(&self, rng: &mut Rng) -> PlanarPose {
        PlanarPose::new(
            rng.random_range(self.min_x_m..=self.max_x_m),
            rng.random_range(self.min_y_m..=self.max_y_m),
            rng.random_range(-std::f64::consts::PI..std::f64::consts::PI),
        )
    }
}
