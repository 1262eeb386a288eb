//! Which of several motions also explains the frames on the way.

use nalgebra::{Matrix2, Point3, Vector3};
use visloc_geom::{CameraFrame, Rigid3};

use super::TwoView;
use crate::{
    lie::CameraFromWorld,
    solve::{Bundle, BundleObservation, BundleSettings, PoseObservation, State, refine_pose},
};

/// Rays (z = 1) of all corners in one frame; `None` where a corner was not found.
pub type ViewRays = Vec<Option<Vector3<f64>>>;

/// A motion with its points, adjusted over all views.
#[derive(Debug, Clone)]
pub struct VerifiedStart {
    /// Pose of the last view; the first is at the origin.
    pub last_from_first: Rigid3<CameraFrame, CameraFrame>,
    /// One entry for each corner, in the first camera; `None` for outliers.
    pub points: Vec<Option<Point3<f64>>>,
    /// Mean cost of an observation: half the squared residual in standard deviations, linear where it is large.
    pub cost: f64,
}

/// Cost of an observation that is not explained.
const OUTLIER_COST: f64 = 3.0;
/// Error of a followed corner, pixels.
const SIGMA_PX: f64 = 0.5;

/// Adjusts the motion and the points of two views together with the views between them. Two views of a plane have two motions
/// that explain them nearly as well; more views tell them apart.
#[must_use]
pub fn verify(candidate: &TwoView, views: &[ViewRays], focal_px: f64) -> Option<VerifiedStart> {
    let whitening = Matrix2::identity() * (focal_px / SIGMA_PX);
    let mut bundle = Bundle::default();
    let mut pose = CameraFromWorld::identity();
    let last = CameraFromWorld::new(
        nalgebra::Rotation3::from_matrix_unchecked(*candidate.motion.rotation()),
        *candidate.motion.translation(),
    );
    for (i, view) in views.iter().enumerate() {
        let known: Vec<PoseObservation> = candidate
            .points
            .iter()
            .zip(view)
            .filter_map(|(point, ray)| Some(PoseObservation::of_point((*point)?, (*ray)?, whitening)))
            .collect();
        pose = match i {
            0 => CameraFromWorld::identity(),
            _ if i + 1 == views.len() => last,
            _ => refine_pose(&State::new(&pose), &known, |_| true, 40.0, 10).pose,
        };
        bundle.cameras.push(pose);
        bundle.is_free.push(i > 0);
    }
    let mut index = Vec::new();
    for (i, point) in candidate.points.iter().enumerate() {
        let Some(point) = point else { continue };
        for (camera, view) in views.iter().enumerate() {
            let Some(ray) = view[i] else { continue };
            bundle.observations.push(BundleObservation {
                point: index.len(),
                camera,
                ray: ray.xy(),
                whitening,
            });
        }
        bundle.points.push(*point);
        index.push(i);
    }
    let report = bundle.solve(&BundleSettings { max_iterations: 15, huber: 2.45 });
    let mut points = vec![None; candidate.points.len()];
    for (i, point) in index.iter().zip(&bundle.points) {
        points[*i] = (point.z > 0.0).then_some(*point);
    }
    let pose = bundle.cameras.last()?;
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(*pose.rotation());
    // A motion that explains fewer corners must not win by that: each that it leaves out costs as much as an outlier.
    let num_left_out = points.iter().filter(|point| point.is_none()).count() * views.len();
    let num = bundle.observations.len() + num_left_out;
    let cost = (report.last_cost + OUTLIER_COST * num_left_out as f64) / num.max(1) as f64;
    Some(VerifiedStart { last_from_first: Rigid3::new(rotation, *pose.translation()), points, cost })
}
