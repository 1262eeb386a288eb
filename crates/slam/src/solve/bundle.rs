//! Bundle adjustment: cameras and points together.

mod equations;
mod errors;

use nalgebra::{Matrix2, Point3, Vector2, Vector3, Vector6};
use visloc_core::geom::{CameraFrame, Rigid3};

use self::equations::{NormalEquations, Step};
pub use self::errors::BundleErrors;
use crate::lie::{CameraFromWorld, log, moved};

/// One measurement.
#[derive(Debug, Clone, Copy)]
pub struct BundleObservation {
    /// Index of the point.
    pub point: usize,
    /// Index of the camera.
    pub camera: usize,
    /// Where it is seen, on the plane z = 1 without distortion.
    pub ray: Vector2<f64>,
    /// Whitens a residual on that plane: square root of the inverse covariance.
    pub whitening: Matrix2<f64>,
}

/// Two cameras at the same place.
#[derive(Debug, Clone, Copy)]
pub struct BundleTie {
    /// Indices of the cameras.
    pub cameras: (usize, usize),
    /// Standard deviation of the distance of their centers along each axis, map units.
    pub sigma: f64,
}

/// A motion between two cameras that is known from elsewhere.
#[derive(Debug, Clone, Copy)]
pub struct BundleMotion {
    /// Indices of the cameras.
    pub cameras: (usize, usize),
    /// The motion.
    pub second_from_first: Rigid3<CameraFrame, CameraFrame>,
    /// Standard deviations: map units along each axis, radians about it.
    pub deviations: (f64, f64),
}

impl BundleMotion {
    /// Error in standard deviations: translation, then rotation.
    fn residual(&self, cameras: &[CameraFromWorld]) -> Vector6<f64> {
        let twist = log(&(self.between(cameras) * self.second_from_first.inverse()));
        twist.component_mul(&self.weights())
    }

    /// The motion as the cameras are now.
    fn between(&self, cameras: &[CameraFromWorld]) -> Rigid3<CameraFrame, CameraFrame> {
        cameras[self.cameras.1] * cameras[self.cameras.0].inverse()
    }

    fn weights(&self) -> Vector6<f64> {
        Vector6::from_fn(|i, _| 1.0 / if i < 3 { self.deviations.0 } else { self.deviations.1 })
    }
}

/// One parameter of the lens through which all cameras of a bundle look, as a change from what the rays were made with.
#[derive(Debug, Clone)]
pub struct BundleLens {
    /// The change.
    pub change: f64,
    /// The change that is expected.
    pub expected: f64,
    /// Standard deviation of what is expected.
    pub sigma: f64,
    /// For each observation the derivative of its ray by the change.
    pub ray_by_change: Vec<Vector2<f64>>,
    /// For each observation the derivative of that by its ray: how much smaller a pixel becomes. Without it, an empty list, pixels keep their
    /// size, which will do for small changes; of larger ones those that make all rays shorter would seem to explain everything better.
    pub size_by_change: Vec<Matrix2<f64>>,
}

/// How a bundle is solved.
#[derive(Debug, Clone, Copy)]
pub struct BundleSettings {
    /// Most Levenberg-Marquardt iterations.
    pub max_iterations: usize,
    /// Residual in standard deviations from which on Huber's cost is linear.
    pub huber: f64,
}

/// How it went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BundleReport {
    /// Iterations done.
    pub iterations: usize,
    /// Cost at the start: half the sum of Huber's function of the whitened residuals.
    pub first_cost: f64,
    /// Cost at the end.
    pub last_cost: f64,
}

/// Cameras, points and what the cameras see. Source: Triggs et al., "Bundle adjustment: a modern synthesis", 1999, section 6.1
/// (Schur complement).
#[derive(Debug, Clone, Default)]
pub struct Bundle {
    /// Poses of the cameras.
    pub cameras: Vec<CameraFromWorld>,
    /// Whether a camera may move; one entry for each camera.
    pub is_free: Vec<bool>,
    /// Places of the points.
    pub points: Vec<Point3<f64>>,
    /// Measurements, ordered by point.
    pub observations: Vec<BundleObservation>,
    /// Cameras that are known to be at the same place.
    pub ties: Vec<BundleTie>,
    /// Motions between cameras that are known from elsewhere.
    pub motions: Vec<BundleMotion>,
    /// What of the camera is to be estimated too.
    pub lens: Vec<BundleLens>,
}

impl BundleTie {
    /// Distance of the centers in standard deviations.
    fn residual(&self, cameras: &[CameraFromWorld]) -> Vector3<f64> {
        let center = |camera: usize| {
            let pose = &cameras[camera];
            -(pose.rotation().transpose() * pose.translation())
        };
        (center(self.cameras.0) - center(self.cameras.1)) / self.sigma
    }
}

/// Damping of the first step of Levenberg and Marquardt, share of the diagonal.
const FIRST_DAMPING: f64 = 1e-4;
/// Least damping.
const LEAST_DAMPING: f64 = 1e-9;
/// Damping beyond which steps are too short to matter.
const MOST_DAMPING: f64 = 1e6;
/// Share of the cost by which an iteration must lower it for another one.
pub(crate) const LEAST_GAIN: f64 = 1e-4;

impl Bundle {
    /// Whitened residual of an observation; `None` behind the camera.
    #[inline]
    #[must_use]
    pub fn residual(&self, observation: &BundleObservation) -> Option<Vector2<f64>> {
        residual_of(&self.cameras[observation.camera], &self.points[observation.point], observation)
    }

    /// An observation as seen through a lens with these changes: its ray, and its whitening, since pixels have changed their size.
    #[inline]
    fn seen(
        &self,
        i: usize,
        observation: &BundleObservation,
        changes: impl Iterator<Item = f64>,
    ) -> BundleObservation {
        let mut seen = *observation;
        for (lens, change) in self.lens.iter().zip(changes) {
            seen.ray += lens.ray_by_change[i] * change;
            if let Some(size) = lens.size_by_change.get(i) {
                seen.whitening -= observation.whitening * size * change;
            }
        }
        seen
    }

    /// Minimizes Huber's cost of all residuals.
    pub fn solve(&mut self, settings: &BundleSettings) -> BundleReport {
        let huber = settings.huber;
        let first_cost = self.cost(&State::of(self), huber);
        let mut report = BundleReport { iterations: 0, first_cost, last_cost: first_cost };
        let mut damping = FIRST_DAMPING;
        let mut equations = NormalEquations::empty(self);
        while report.iterations < settings.max_iterations {
            report.iterations += 1;
            equations.set(self, huber);
            let Some((state, cost)) = self.lower(&equations, &mut damping, report.last_cost, huber) else {
                break;
            };
            (self.cameras, self.points) = (state.cameras, state.points);
            for (lens, change) in self.lens.iter_mut().zip(state.lens) {
                lens.change = change;
            }
            let gain = (report.last_cost - cost) / report.last_cost;
            report.last_cost = cost;
            if gain < LEAST_GAIN {
                break;
            }
        }
        report
    }

    /// A step that lowers the cost, with as much damping as that takes; `None` if there is none.
    fn lower(
        &self,
        equations: &NormalEquations,
        damping: &mut f64,
        last_cost: f64,
        huber: f64,
    ) -> Option<(State, f64)> {
        while *damping <= MOST_DAMPING {
            if let Some(step) = equations.solve(self, *damping) {
                let state = self.stepped(&step);
                let cost = self.cost(&state, huber);
                if cost < last_cost {
                    *damping = (*damping * 0.2).max(LEAST_DAMPING);
                    return Some((state, cost));
                }
            }
            *damping *= 10.0;
        }
        None
    }

    fn stepped(&self, step: &Step) -> State {
        let cameras = self.cameras.iter().zip(&step.cameras);
        let cameras = cameras.map(|(camera, twist)| twist.map_or(*camera, |twist| moved(&twist, camera)));
        State {
            cameras: cameras.collect(),
            points: self.points.iter().zip(&step.points).map(|(point, step)| point + step).collect(),
            lens: self.lens.iter().zip(&step.lens).map(|(lens, step)| lens.change + step).collect(),
        }
    }

    fn cost(&self, state: &State, huber: f64) -> f64 {
        let cost_of = |(i, observation): (usize, &BundleObservation)| {
            let observation = self.seen(i, observation, state.lens.iter().copied());
            let camera = &state.cameras[observation.camera];
            let residual = residual_of(camera, &state.points[observation.point], &observation);
            // A point behind a camera costs as much as a gross outlier.
            let norm = residual.map_or(100.0 * huber, |error| error.norm());
            if norm > huber { huber * (norm - 0.5 * huber) } else { 0.5 * norm * norm }
        };
        let of_ties =
            self.ties.iter().map(|tie| 0.5 * tie.residual(&state.cameras).norm_squared()).sum::<f64>();
        let of_motions = self
            .motions
            .iter()
            .map(|motion| 0.5 * motion.residual(&state.cameras).norm_squared())
            .sum::<f64>();
        let of_lens = self.lens.iter().zip(&state.lens).map(|(lens, change)| lens.cost(*change)).sum::<f64>();
        self.observations.iter().enumerate().map(cost_of).sum::<f64>() + of_ties + of_motions + of_lens
    }
}

impl BundleLens {
    /// Cost of a change that was not expected.
    fn cost(&self, change: f64) -> f64 {
        0.5 * ((change - self.expected) / self.sigma).powi(2)
    }
}

/// What a bundle estimates.
struct State {
    cameras: Vec<CameraFromWorld>,
    points: Vec<Point3<f64>>,
    lens: Vec<f64>,
}

impl State {
    fn of(bundle: &Bundle) -> Self {
        Self {
            cameras: bundle.cameras.clone(),
            points: bundle.points.clone(),
            lens: bundle.lens.iter().map(|lens| lens.change).collect(),
        }
    }
}

#[inline]
fn residual_of(
    camera: &CameraFromWorld,
    point: &Point3<f64>,
    observation: &BundleObservation,
) -> Option<Vector2<f64>> {
    let point = camera.transform(point);
    if point.z <= 1e-9 {
        return None;
    }
    let inv_z = 1.0 / point.z;
    Some(observation.whitening * (Vector2::new(point.x * inv_z, point.y * inv_z) - observation.ray))
}

#[cfg(test)]
mod tests;
