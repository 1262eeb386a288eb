//! How likely a percept is in each state: what landmarks look like from poses spread over the state.
//!
//! The source learns, for a robot whose head does not turn, how often each size and each place of the goal in the image
//! is seen in each state. For a head that turns, the same follows from geometry for every view: poses spread over a
//! state (instead of captures) are projected into the camera, as it is turned at the moment. So "not seen" speaks
//! against exactly those states from which the landmark would be in this view, and says nothing about others.

use visloc_core::geom::PlanarPose;

use super::{
    ExpectedViewConfig, Grid,
    projection::{CameraView, RobotFromWorld, VisiblePart},
};
use crate::{observation::Landmark, vision::Percept};

/// Width of the images that the areas of the configuration are given for.
const AREA_IMAGE_WIDTH_PX: f64 = 320.0;

/// Expected views of the landmarks in all states.
#[derive(Debug, Clone)]
pub(super) struct ExpectedViews {
    config: ExpectedViewConfig,
    landmarks: Vec<Landmark>,
    /// Middle of each state, `world_from_state`.
    middles: Vec<PlanarPose>,
    /// Poses spread over a state, seen from its middle.
    offsets: Vec<PlanarPose>,
}

impl ExpectedViews {
    pub fn new(config: ExpectedViewConfig, grid: &Grid, landmarks: Vec<Landmark>) -> Self {
        let middles = (0..grid.num_states()).map(|index| grid.pose(index)).collect();
        let offsets = (0..config.samples_per_state)
            .map(|i| {
                let spread = |base: u32| radical_inverse(i + 1, base) - 0.5;
                PlanarPose {
                    x_m: spread(2) * grid.tile_m(),
                    y_m: spread(3) * grid.tile_m(),
                    yaw_rad: spread(5) * grid.heading_step_rad(),
                }
            })
            .collect();
        Self { config, landmarks, middles, offsets }
    }

    /// The likelihood of a percept in every state, for a robot that stands at `residual` from the state's middle.
    /// Returns whether any landmark was seen.
    pub fn likelihoods(&self, percept: &Percept, residual: &PlanarPose, out: &mut Vec<f64>) -> bool {
        let camera = CameraView::new(percept);
        let seen: Vec<Option<VisiblePart>> = self.landmarks.iter().map(|l| seen_part(percept, l)).collect();
        let model = SightModel::new(&self.config, percept, camera.focal_px());
        out.clear();
        for middle in &self.middles {
            let at_residual = middle.compose(residual);
            let mut sum = 0.0;
            for offset in &self.offsets {
                let pose = RobotFromWorld::new(&at_residual.compose(offset));
                let parts = self.landmarks.iter().zip(&seen);
                sum += parts
                    .map(|(landmark, seen)| model.likelihood(seen.as_ref(), camera.visible(&pose, landmark)))
                    .product::<f64>();
            }
            out.push(sum / self.offsets.len() as f64);
        }
        seen.iter().any(Option::is_some)
    }
}

/// All valid blobs of a landmark's kind together.
fn seen_part(percept: &Percept, landmark: &Landmark) -> Option<VisiblePart> {
    let (mut area_px, mut moment) = (0.0, 0.0);
    for blob in percept.blobs.iter().filter(|blob| blob.kind == landmark.kind) {
        area_px += blob.area_px;
        moment += blob.area_px * percept.camera.ideal_px(&blob.centroid_px).x;
    }
    (area_px > 0.0).then(|| VisiblePart { area_px, column_px: moment / area_px })
}

/// The density of what is seen, given what is in view.
struct SightModel {
    config: ExpectedViewConfig,
    weak_area_px: f64,
    /// Turns columns into standard deviations of the bearing.
    sigmas_per_px: f64,
    /// Density of a sighting that can be anything, per radian and logarithm of area.
    anything: f64,
    /// Density at the peak of a normal sighting, in the same units.
    peak: f64,
}

impl SightModel {
    fn new(config: &ExpectedViewConfig, percept: &Percept, focal_px: f64) -> Self {
        /// Range of the logarithm of a goal's area between far away and filling the image.
        const LOG_AREA_RANGE: f64 = 5.0;
        let width_px = f64::from(percept.camera.size_px().0);
        let bearing_sigma_rad = config.bearing_sigma_deg.to_radians();
        let width_rad = 2.0 * (width_px / 2.0 / focal_px).atan();
        Self {
            config: *config,
            weak_area_px: config.weak_area_px * (width_px / AREA_IMAGE_WIDTH_PX).powi(2),
            sigmas_per_px: 1.0 / (focal_px * bearing_sigma_rad),
            anything: 1.0 / (width_rad * LOG_AREA_RANGE),
            peak: 1.0 / (std::f64::consts::TAU * bearing_sigma_rad * config.log_area_sigma),
        }
    }

    /// p(seen or not | in view or not), with the density of area and bearing if something is seen.
    fn likelihood(&self, seen: Option<&VisiblePart>, expected: Option<VisiblePart>) -> f64 {
        let c = &self.config;
        let detection =
            expected.map_or(0.0, |part| c.detection * part.area_px / (part.area_px + self.weak_area_px));
        let detection = c.false_alarm + (1.0 - c.false_alarm) * detection;
        let Some(seen) = seen else { return 1.0 - detection };
        let Some(expected) = expected else { return detection * self.anything };
        let bearing = (seen.column_px - expected.column_px) * self.sigmas_per_px;
        let area = (seen.area_px / expected.area_px).ln() / c.log_area_sigma;
        let normal = self.peak * (-0.5 * (bearing * bearing + area * area)).exp();
        detection * ((1.0 - c.outlier) * normal + c.outlier * self.anything)
    }
}

/// Evenly spread numbers in [0, 1). Source: Halton, 1960.
fn radical_inverse(mut index: usize, base: u32) -> f64 {
    let base = base as usize;
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        {
            digit /= base as f64;
            value += (index % base) as f64 * digit;
        }
        index /= base;
    }
    value
}
