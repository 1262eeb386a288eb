//! What is known of the constant error of the camera's direction.

use nalgebra::{Matrix3, Vector3};
use visloc_core::{Rng, gaussian};

use super::RefinementConfig;
use crate::camera_misalignment::{CameraMisalignment, Uncertain};

/// What is known of the constant error of the camera's direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Mount {
    /// Rotation vector in the camera frame, radians: the true camera frame, seen from the reported one.
    pub tilt_rad: Vector3<f64>,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
}

impl Mount {
    /// Of a robot of which nothing is known.
    pub fn unknown(config: &RefinementConfig) -> Self {
        let covariance = Matrix3::from_diagonal(&config.mount_error_rad().map(|sigma| sigma * sigma));
        Self { tilt_rad: Vector3::zeros(), covariance }
    }

    /// Standard deviations, radians.
    pub fn sigma_rad(&self) -> Vector3<f64> {
        self.covariance.diagonal().map(|variance| variance.max(0.0).sqrt())
    }

    /// An error that it may have, at random; without correlations, of which a search has no need.
    pub fn draw(&self, rng: &mut Rng) -> Vector3<f64> {
        self.tilt_rad + self.sigma_rad().map(|sigma| if sigma > 0.0 { gaussian(rng, sigma) } else { 0.0 })
    }

    /// The error in words that people use.
    pub fn camera_error(&self, is_confirmed: bool) -> CameraMisalignment {
        let (tilt, sigma) = (self.tilt_rad.map(f64::to_degrees), self.sigma_rad().map(f64::to_degrees));
        // x of the camera points to the right and y down: turning about x by a positive angle lifts the view, about y takes it to the right.
        CameraMisalignment {
            pitch_down_deg: Uncertain { mean: -tilt.x, sigma: sigma.x },
            roll_clockwise_deg: Uncertain { mean: tilt.z, sigma: sigma.z },
            yaw_left_deg: Uncertain { mean: -tilt.y, sigma: sigma.y },
            is_confirmed,
        }
    }

    /// Whether this robot's camera is known much better than that of any robot.
    pub fn is_known(&self, config: &RefinementConfig) -> bool {
        self.sigma_rad().x < 0.5 * config.mount_pitch_rad
    }

    /// How many errors to draw for a search, so that there is one for all that the tilt of one image may be beside it.
    pub fn num_draws(&self, config: &RefinementConfig) -> usize {
        let of_image_rad = config.tilt_noise_rad.hypot(config.tilt_bias_rad);
        (self.sigma_rad().max() / of_image_rad).ceil().clamp(1.0, 100.0) as usize
    }

    /// How much an error speaks against the place that needs it: minus the logarithm of its probability density among all robots, against
    /// the peak. What is known of this robot holds a track by itself.
    pub fn surprise(&self, tilt_rad: &Vector3<f64>, config: &RefinementConfig) -> f64 {
        if self.is_known(config) {
            return 0.0;
        }
        let sigmas = config.mount_error_rad();
        let terms = tilt_rad.iter().zip(&sigmas).filter(|(_, sigma)| **sigma > 0.0);
        0.5 * terms.map(|(tilt, sigma)| (tilt / sigma).powi(2)).sum::<f64>()
    }

    /// The robot has been lost for so long: something may have bent its camera.
    pub fn relax(&mut self, secs: f64, config: &RefinementConfig) {
        let forgotten = 1.0 - (-secs / config.mount_secs).exp();
        self.covariance += (Self::unknown(config).covariance - self.covariance) * forgotten;
    }
}
