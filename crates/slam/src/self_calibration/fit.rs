//! Focal length, principal point and distortion of a camera, estimated with a map that was seen through it.

use nalgebra::{Matrix2, Point2, Vector2};
use visloc_core::geom::{Camera, Distortion};

use super::{MAX_ROUNDS, SETTLED};
use crate::{
    map::{KeyframeId, Map},
    mapping::{
        adjust::{CHI2, Index, collect, take_over},
        lens::STEP,
    },
    solve::{Bundle, BundleLens, BundleObservation, BundleSettings},
    track::focal_px,
};

/// Logarithm of the focal length, both coordinates of the principal point in widths of the image from its middle, and by what share of
/// their distance from the middle each of two radial coefficients moves the corners.
const NUM: usize = 5;
/// Standard deviations of what is expected of them. The map was made with a focal length that is believed to be right to an eighth; lenses are
/// centered to some percent of the width and move the corners by some tenths.
const SIGMAS: [f64; NUM] = [0.125, 0.02, 0.02, 0.15, 0.1];

/// What is estimated of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lens {
    size_px: (u32, u32),
    values: [f64; NUM],
}

impl Lens {
    /// A lens without distortion over the middle of the image.
    pub fn new(size_px: (u32, u32), focal_px: f64) -> Self {
        Self { size_px, values: [focal_px.ln(), 0.0, 0.0, 0.0, 0.0] }
    }

    /// Logarithm of the focal length.
    pub fn log_focal(&self) -> f64 {
        self.values[0]
    }

    /// The camera; `None` if there is no such lens.
    pub fn camera(&self) -> Option<Camera> {
        let [log_focal, x, y, first, second] = self.values;
        let (width, height) = (f64::from(self.size_px.0), f64::from(self.size_px.1));
        let focal = log_focal.exp();
        let center = (0.5 * (width - 1.0) + x * width, 0.5 * (height - 1.0) + y * width);
        let corner2 = ((0.5 * width).hypot(0.5 * height) / focal).powi(2);
        let radial = [first / corner2, second / (corner2 * corner2), 0.0, 0.0, 0.0];
        Camera::checked(self.size_px, (focal, focal), center, Distortion::RadialTangential(radial)).ok()
    }

    fn changed(&self, by: [f64; NUM]) -> Self {
        Self { values: std::array::from_fn(|i| self.values[i] + by[i]), ..*self }
    }
}

/// A lens as a map tells it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub lens: Lens,
    /// Standard deviation of the logarithm of the focal length, if nothing was expected of it.
    pub focal_deviation: f64,
}

/// Adjusts a map together with the lens that it was seen through. `None` if the equations have no solution.
pub(super) fn fit(map: &mut Map, followed: Lens) -> Option<Fit> {
    let mut lens = followed;
    let (design_effect, prior) = design_effect(map, &lens)?;
    for _ in 0..MAX_ROUNDS {
        let (mut bundle, index) = seen_through(map, &lens)?;
        bundle.lens = parameters(map, (&bundle, &index), (&lens, &followed), SIGMAS, design_effect)?;
        bundle.solve(&BundleSettings { max_iterations: MAX_ROUNDS, huber: CHI2.sqrt() });
        let change: [f64; NUM] = std::array::from_fn(|i| bundle.lens[i].change);
        // Derivatives hold about as far as what is expected.
        let share = (SIGMAS[0] / change[0].abs()).min(1.0);
        lens = lens.changed(change.map(|change| share * change));
        take_over(map, &bundle, &index);
        if change[0].abs() < SETTLED {
            break;
        }
    }
    let (mut bundle, index) = seen_through(map, &lens)?;
    let sigmas = std::array::from_fn(|i| if i == 0 { 1.0 } else { SIGMAS[i] });
    bundle.lens = parameters(map, (&bundle, &index), (&lens, &followed), sigmas, design_effect)?;
    let covariance = bundle.lens_covariance(CHI2.sqrt(), prior)?;
    Some(Fit { lens, focal_deviation: (covariance[(0, 0)] * design_effect).sqrt() })
}

/// The whole map as it is seen through a lens.
fn seen_through(map: &mut Map, lens: &Lens) -> Option<(Bundle, Index)> {
    let camera = lens.camera()?;
    map.look_through(&camera);
    let keyframes: Vec<KeyframeId> = map.keyframes().map(|(id, _)| id).collect();
    Some(collect(map, &keyframes, focal_px(&camera)))
}

/// Factor on variances since errors of observations are alike, in a part of the image and of a landmark in all keyframes, so that each landmark counts once; and how far cameras may be from where they are, so that there is an answer: landmarks
/// that hardly tell where they are leave equations without a solution unless cameras are about known.
fn design_effect(map: &mut Map, lens: &Lens) -> Option<(f64, (f64, f64))> {
    let (bundle, index) = seen_through(map, lens)?;
    let depth = index.keyframes.first().and_then(|id| map.depth_of(*id)).unwrap_or(1.0);
    let mut priors = [1.0, SIGMAS[0], SIGMAS[0].powi(2)].into_iter().map(|share| (share * depth, share));
    let num_of_each = bundle.observations.len() as f64 / bundle.points.len().max(1) as f64;
    priors.find_map(|prior| Some((num_of_each * bundle.errors(CHI2.sqrt(), prior)?.design_effect, prior)))
}

/// The parameters of a lens for a bundle that is seen through it. Observations tell less than they seem to by the design effect, so what is expected
/// counts as much more.
fn parameters(
    map: &Map,
    (bundle, index): (&Bundle, &Index),
    (lens, followed): (&Lens, &Lens),
    sigmas: [f64; NUM],
    design_effect: f64,
) -> Option<Vec<BundleLens>> {
    let px = |o: &BundleObservation| {
        Some(map.landmark(index.landmarks[o.point]).observation_in(index.keyframes[o.camera])?.px)
    };
    let px = bundle.observations.iter().map(px).collect::<Option<Vec<_>>>()?;
    let camera = lens.camera()?;
    let expected = [followed.log_focal(), 0.0, 0.0, 0.0, 0.0];
    let parameter = |i: usize| {
        let mut step = [0.0; NUM];
        step[i] = STEP;
        let stepped = lens.changed(step).camera()?;
        let shift = |px: &Point2<f64>| (stepped.bearing(px).xy() - camera.bearing(px).xy()) / STEP;
        let size = |px: &Point2<f64>| {
            let neighbors = [Vector2::x(), Vector2::y()].map(|step| px + step);
            let (ray, own) = (camera.bearing(px).xy(), shift(px));
            let pixel = Matrix2::from_columns(&neighbors.map(|px| camera.bearing(&px).xy() - ray));
            let change = Matrix2::from_columns(&neighbors.map(|px| shift(&px) - own));
            pixel.try_inverse().map_or_else(Matrix2::zeros, |by_ray| change * by_ray)
        };
        Some(BundleLens {
            change: 0.0,
            expected: expected[i] - lens.values[i],
            sigma: sigmas[i] / design_effect.sqrt(),
            ray_by_change: px.iter().map(shift).collect(),
            size_by_change: px.iter().map(size).collect(),
        })
    };
    (0..NUM).map(parameter).collect()
}
