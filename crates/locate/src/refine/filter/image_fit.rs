//! How well a pose explains the features of an image, and the equations that make it better.

use super::CameraMatrix;
use crate::{
    observation::features::{CameraState, CameraVector, FeatureModel},
    refine::RefinementConfig,
};

/// Group of the features that belong to landmarks.
pub(in crate::refine) const LANDMARKS: usize = 1;

/// Fewer features of a landmark than this neither confirm nor contradict.
const MIN_LANDMARK_FEATURES: f64 = 3.0;

/// The features that a pose explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::refine) struct Agreement {
    /// Shares of the features of each group that are as good as all.
    full_shares: [f64; 2],
    /// Sum of the agreements and number of the features, for each group.
    groups: [(f64, f64); 2],
}

/// What fits one image best.
#[derive(Debug, Clone, Copy)]
pub(in crate::refine) struct ImageFit {
    /// Pose, tilt and height.
    pub at: CameraVector,
    /// Information of this image alone about them.
    pub information: CameraMatrix,
    /// The features that they explain.
    pub agreement: Agreement,
}

impl Agreement {
    /// Of no features yet.
    fn new(full_shares: [f64; 2]) -> Self {
        Self { full_shares, groups: [(0.0, 0.0); 2] }
    }

    /// How well landmarks in view are explained, -1 to 1: positive if more of their features find a counterpart than
    /// chance would bring about. `None` if too few are in view to tell.
    pub fn of_landmarks(&self) -> Option<f64> {
        let (sum, count) = self.groups[LANDMARKS];
        let by_chance = 0.5 * self.full_shares[LANDMARKS];
        (count >= MIN_LANDMARK_FEATURES).then(|| ((sum / count - by_chance) / by_chance).clamp(-1.0, 1.0))
    }

    /// How well the features are explained, 0 to 1; lines and goals count the same, as in the documents, but a group of
    /// few features counts less.
    pub fn value(&self) -> f64 {
        let weight = |count: f64| (count / 4.0).min(1.0);
        let (mut sum, mut total) = (0.0, 0.0);
        for ((agreeing, count), full) in self.groups.into_iter().zip(self.full_shares) {
            if count > 0.0 {
                sum += weight(count) * (agreeing / count / full).min(1.0);
                total += weight(count);
            }
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }
}

/// Normal equations of one image over (x, y, heading, tilt, height).
pub(super) struct Fit {
    pub information: CameraMatrix,
    pub gradient: CameraVector,
    pub agreement: Agreement,
}

/// Matches one feature in `stride` from one state and adds up their normal equations.
pub(super) fn fit(
    model: &dyn FeatureModel,
    at: &CameraVector,
    gate_px: f64,
    stride: usize,
    config: &RefinementConfig,
) -> Fit {
    let state = CameraState::from(at);
    let mut fit = Fit {
        information: CameraMatrix::zeros(),
        gradient: CameraVector::zeros(),
        agreement: Agreement::new(model.full_shares()),
    };
    let mut total_weight = 0.0;
    model.visit_matches(&state, gate_px, stride, &mut |feature| {
        let group = &mut fit.agreement.groups[feature.group];
        group.1 += 1.0;
        let Some(residual) = feature.residual else {
            group.0 += feature.unmatched_agreement;
            return;
        };
        let error2 = residual.error_px.powi(2);
        group.0 += (-0.5 * error2 / config.agreement_px.powi(2)).exp().max(feature.unmatched_agreement);
        let weight = residual.weight(gate_px);
        total_weight += weight;
        let weighted = residual.jacobian * weight;
        fit.information += weighted * residual.jacobian.transpose();
        fit.gradient -= weighted * residual.error_px;
    });
    let independent = (config.max_independent_pixels / total_weight.max(1e-9)).min(1.0);
    let scale = independent / (config.pixel_noise_px * model.noise()).powi(2);
    fit.information *= scale;
    fit.gradient *= scale;
    fit
}
