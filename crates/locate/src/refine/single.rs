//! All places that explain one image.

use std::f64::consts::TAU;

use nalgebra::Matrix3;
use visloc_core::{Rng, geom::PlanarPose};

use super::{
    RefinementConfig,
    filter::PoseFilter,
    mount::Mount,
    search::{Candidate, PlaceSearch},
    turned::Turned,
};
use crate::{
    ObservationModel, Region,
    observation::features::{CameraState, CameraVector, FeatureModel},
    vision::Percept,
};

/// Gates of the fit, from coarse to fine, pixels.
const GATES_PX: [f64; 8] = [40.0, 25.0, 15.0, 10.0, 8.0, 8.0, 8.0, 8.0];
/// A feature that belongs to nothing on the map lies anywhere within so many pixels of something that is; as the coarsest gate.
const ASTRAY_PX: f64 = GATES_PX[0];
/// Share of the features that belong to nothing on the map: robots, boards, people.
const OUTLIERS: f64 = 0.15;

/// A place that explains an image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Explanation {
    /// The pose of the robot and the camera's errors that fit best.
    pub camera: CameraState,
    /// Logarithm of the marginal likelihood of the image's features against that of features that belong to nothing on the map: how well they
    /// fit, less for what may be anything before and has to be just so.
    pub log_evidence: f64,
}

/// Searches places for one image at leisure.
pub(crate) struct SingleImage {
    features: Box<dyn FeatureModel>,
    places: PlaceSearch,
    turned: Turned,
}

impl SingleImage {
    /// A search on a map; `features` are matched to it, `pixels` weigh places.
    pub fn new(features: Box<dyn FeatureModel>, pixels: Box<dyn ObservationModel>) -> Self {
        Self { features, places: PlaceSearch::new(pixels), turned: Turned::default() }
    }

    /// The pose from which everything looks the same.
    pub fn mirrored(&self, pose: &PlanarPose) -> Option<PlanarPose> {
        self.features.mirrored(pose)
    }

    /// Appends the places that fit: of `num_poses` suggestions the `num_fits` best ones are fitted. The camera may be off as `config` says.
    pub fn explain(
        &mut self,
        percept: &Percept,
        config: &RefinementConfig,
        (num_poses, num_fits): (usize, usize),
        rng: &mut Rng,
        found: &mut Vec<Explanation>,
    ) {
        let mount = Mount::unknown(config);
        let rounds = mount.num_draws(config);
        self.places.begin();
        for _ in 0..rounds {
            let tilt_rad = mount.draw(rng);
            let turned = self.turned.turn(percept, &tilt_rad);
            self.features.condition_on(turned);
            let effort = (num_poses.div_ceil(rounds), num_fits);
            self.places.search((turned, &tilt_rad), self.features.as_ref(), effort, |_| false, rng);
        }
        self.features.condition_on(percept);
        if self.features.num_features() > 0 {
            let region = self.places.region();
            let candidates = self.places.found();
            found.extend(candidates.filter_map(|candidate| self.fit(&candidate, &mount, &region, config)));
        }
    }

    fn fit(
        &self,
        candidate: &Candidate,
        mount: &Mount,
        region: &Region,
        config: &RefinementConfig,
    ) -> Option<Explanation> {
        let model = self.features.as_ref();
        let mut filter = PoseFilter::new(&candidate.world_from_robot, mount, config);
        let (at, _) = filter.fit_from(&candidate.tilt_rad, model, &GATES_PX, config);
        let camera = CameraState::from(&at);
        let is_inside = at.iter().all(|v| v.is_finite()) && region.contains(&camera.world_from_robot);
        let log_evidence = log_likelihood(model, &camera, config)
            - surprise(&at, config)
            - log_volumes(region, &filter.pose_covariance());
        is_inside.then_some(Explanation { camera, log_evidence })
    }
}

/// Logarithm of the likelihood of the features, against features that belong to nothing: each belongs to its counterpart with Gaussian
/// noise, or to nothing. Neighboring pixels err alike, so all count as few.
#[allow(clippy::cast_precision_loss)]
fn log_likelihood(model: &dyn FeatureModel, camera: &CameraState, config: &RefinementConfig) -> f64 {
    let sigma_px = config.agreement_px;
    let peak = (1.0 - OUTLIERS) * 2.0 * ASTRAY_PX / (sigma_px * TAU.sqrt());
    let mut sum = 0.0;
    model.visit_matches(camera, ASTRAY_PX, 1, &mut |feature| {
        let error_px = feature.residual.map_or(f64::INFINITY, |residual| residual.error_px);
        let elsewhere = OUTLIERS + (1.0 - OUTLIERS) * feature.unmatched_agreement;
        sum += (peak * (-0.5 * (error_px / sigma_px).powi(2)).exp() + elsewhere).ln();
    });
    let num_features = model.num_features() as f64;
    sum * (config.max_independent_pixels / num_features).min(1.0)
}

/// How improbable the tilt and height of the camera are: minus the logarithm of their density against its peak.
fn surprise(at: &CameraVector, config: &RefinementConfig) -> f64 {
    let mount = config.mount_error_rad();
    let slow = config.tilt_bias_rad.hypot(config.tilt_noise_rad);
    let sigmas = [mount.x.hypot(slow), mount.y.hypot(slow), mount.z.hypot(slow), config.raise_bias_m];
    0.5 * sigmas.iter().enumerate().map(|(i, sigma)| (at[3 + i] / sigma).powi(2)).sum::<f64>()
}

/// Logarithm of the volume of all poses against that of the poses that fit.
fn log_volumes(region: &Region, covariance: &Matrix3<f64>) -> f64 {
    let area_m2 = (region.max_x_m - region.min_x_m) * (region.max_y_m - region.min_y_m);
    let fitting = TAU.powf(1.5) * covariance.determinant().max(1e-18).sqrt();
    (area_m2 * TAU / fitting).ln()
}
