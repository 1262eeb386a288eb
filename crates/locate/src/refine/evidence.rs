//! What one view tells about a place: the marginal likelihood of its features.
//!
//! Source: MacKay, "Information Theory, Inference, and Learning Algorithms", 2003, chapter 28: how well the best fit explains the data, times
//! the share of what was possible before that fits (Laplace's approximation).

use std::f64::consts::TAU;

use nalgebra::{Matrix4, Vector4};

use super::{
    RefinementConfig,
    filter::{CameraMatrix, ImageFit},
    likelihood::{Told, log_likelihood},
};
use crate::{
    Region,
    observation::features::{CameraState, FeatureModel},
};

/// Logarithm of the marginal likelihood of the image's features, against that of features that belong to nothing on the map, if the robot may
/// be anywhere in the region: how well they fit, less for what may be anything before and has to be just so. How improbable the camera is that
/// this needs is not in it: that counts once for a robot, and not for each image.
pub(super) fn log_evidence(
    model: &dyn FeatureModel,
    fit: &ImageFit,
    region: &Region,
    config: &RefinementConfig,
) -> Told {
    let information = fit.information * model.noise().powi(2);
    let mut told = log_likelihood(model, &CameraState::from(&fit.at), config);
    told.by_all += log_share(&information, &camera_spread(config), region, config);
    told
}

/// How improbable tilt and height of the camera are among all robots: minus the logarithm of their density against its peak.
pub(super) fn surprise(fit: &ImageFit, config: &RefinementConfig) -> f64 {
    0.5 * fit.at.fixed_rows::<4>(3).component_div(&camera_spread(config)).norm_squared()
}

/// Standard deviations of the camera's tilt and height among all robots.
fn camera_spread(config: &RefinementConfig) -> Vector4<f64> {
    let slow = config.tilt_bias_rad.hypot(config.tilt_noise_rad);
    let mount = config.mount_error_rad();
    Vector4::new(mount.x.hypot(slow), mount.y.hypot(slow), mount.z.hypot(slow), config.raise_bias_m)
}

/// Logarithm of the share of all poses and cameras that fit about as well; the information is that of an image 320 px wide.
fn log_share(
    information: &CameraMatrix,
    spread: &Vector4<f64>,
    region: &Region,
    config: &RefinementConfig,
) -> f64 {
    /// Volume under a Gaussian, for each of the three coordinates of a pose: those of the camera are against their prior.
    const POSE: f64 = 1.5;
    let prior = Matrix4::from_diagonal(&spread.map(|sigma| sigma.powi(-2)));
    // Counted by what a feature errs by in the likelihood above, in which errors that repeat are contained, whatever the size of the image.
    let mut precision = information * (config.pixel_noise_px / config.agreement_px).powi(2);
    let mut camera = precision.fixed_view_mut::<4, 4>(3, 3);
    camera += prior;
    // What the image does not tell of a pose it may be anywhere in the region.
    let (size_x_m, size_y_m) = (region.max_x_m - region.min_x_m, region.max_y_m - region.min_y_m);
    for (i, size) in [size_x_m, size_y_m, TAU].into_iter().enumerate() {
        precision[(i, i)] += TAU / (size * size);
    }
    let before = (size_x_m * size_y_m * TAU).ln() - 0.5 * prior.determinant().ln();
    POSE * TAU.ln() - 0.5 * precision.determinant().max(f64::MIN_POSITIVE).ln() - before
}
