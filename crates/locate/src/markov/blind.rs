//! What is left of an answer while images show nothing.

use nalgebra::{Matrix3, Vector3};

use crate::{MotionConfig, PlanarMotion};

/// The time since an image last showed a landmark, as far as images showed nothing at all. The belief does not know of it: it is moved by
/// actions only, and a robot that stands does none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blind {
    /// What is left of the reliability, 0 to 1.
    pub trust: f64,
    /// What the covariance has gained.
    pub covariance: Matrix3<f64>,
}

impl Default for Blind {
    fn default() -> Self {
        Self { trust: 1.0, covariance: Matrix3::zeros() }
    }
}

impl Blind {
    /// One more image that shows nothing, so many seconds after the last one.
    pub fn extend(
        &mut self,
        secs: f64,
        blind_secs: f64,
        motion: Option<&PlanarMotion>,
        config: &MotionConfig,
    ) {
        let (noise_m, noise_rad) = motion.map_or((0.0, 0.0), |m| (m.position_noise_m, m.heading_noise_rad));
        let variance = |of_motion: f64, of_a_second: f64| of_motion.powi(2) + of_a_second.powi(2) * secs;
        let place = variance(noise_m, config.blind_noise_m);
        let heading = variance(noise_rad, config.blind_noise_rad);
        self.covariance += Matrix3::from_diagonal(&Vector3::new(place, place, heading));
        self.trust *= (-secs / blind_secs).exp();
    }
}
