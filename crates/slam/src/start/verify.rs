//! Which of several motions also explains the frames on the way.

use nalgebra::{Matrix2, Point3, Vector3};
use visloc_core::geom::{CameraFrame, Rigid3};

use super::TwoView;
use crate::{
    lie::CameraFromWorld,
    solve::{Bundle, BundleMotion, BundleObservation, BundleSettings, PoseObservation, State, refine_pose},
    track::whitening,
};

/// Where a corner was found in one frame.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// Its ray, z = 1.
    pub ray: Vector3<f64>,
    /// Covariance of its place, squared pixels. Long along an edge.
    pub covariance_px: Matrix2<f64>,
}

/// All corners in one frame; `None` where a corner was not found.
pub type ViewRays = Vec<Option<Sight>>;

/// A motion with its points, adjusted over all views.
#[derive(Debug, Clone)]
pub struct VerifiedStart {
    /// Pose of the last view; the first is at the origin.
    pub last_from_first: Rigid3<CameraFrame, CameraFrame>,
    /// One entry for each corner, in the first camera; `None` for outliers.
    pub points: Vec<Option<Point3<f64>>>,
    /// For each corner the mean cost of its observations: half the squared residual in standard deviations, capped where it is large.
    pub corner_costs: Vec<f64>,
    /// Mean of them.
    pub cost: f64,
    /// Mean cost of the observations below the cap.
    pub inlier_cost: f64,
}

/// Cost of an observation that is not explained.
const OUTLIER_COST: f64 = 3.0;
/// Residuals from which on a corner is left out, in standard deviations; first with care, since outliers still bend the motion.
const MOST_SIGMAS: [f64; 2] = [8.0, 4.0];
/// Error of a followed corner beside what its patch tells, pixels: the patch is no plane, and its warp is estimated.
pub const SIGMA_PX: f64 = 0.35;

/// Covariance of a followed corner, from that of its patch.
#[must_use]
pub fn followed_covariance(covariance_px: &Matrix2<f64>) -> Matrix2<f64> {
    covariance_px + Matrix2::identity() * (SIGMA_PX * SIGMA_PX)
}

/// Adjusts the motion and the points of two views together with the views between them. Two views of a plane have two motions
/// that explain them nearly as well; more views tell them apart. What is known of the motion from elsewhere counts by its deviations.
#[must_use]
pub fn verify(
    candidate: &TwoView,
    views: &[ViewRays],
    known: Option<BundleMotion>,
    focal_px: f64,
) -> Option<VerifiedStart> {
    let whiten = |sight: &Sight| whitening(focal_px, &followed_covariance(&sight.covariance_px));
    let mut bundle = Bundle { motions: known.into_iter().collect(), ..Bundle::default() };
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
            .filter_map(|(point, sight)| {
                let sight = sight.as_ref()?;
                Some(PoseObservation::of_point((*point)?, sight.ray, whiten(sight)))
            })
            .collect();
        pose = match i {
            0 => CameraFromWorld::identity(),
            _ if i + 1 == views.len() => last,
            _ => refine_pose(&State::new(&pose), None, &known, |_| true, 40.0, 10).pose,
        };
        bundle.cameras.push(pose);
        bundle.is_free.push(i > 0);
    }
    let mut index = Vec::new();
    for (i, point) in candidate.points.iter().enumerate() {
        let Some(point) = point else { continue };
        for (camera, view) in views.iter().enumerate() {
            let Some(sight) = &view[i] else { continue };
            bundle.observations.push(BundleObservation {
                point: index.len(),
                camera,
                ray: sight.ray.xy(),
                whitening: whiten(sight),
            });
        }
        bundle.points.push(*point);
        index.push(i);
    }
    let outliers = solve_without_outliers(&mut bundle);
    let mut points = vec![None; candidate.points.len()];
    for ((i, point), is_outlier) in index.iter().zip(&bundle.points).zip(&outliers) {
        points[*i] = (point.z > 0.0 && !is_outlier).then_some(*point);
    }
    let pose = bundle.cameras.last()?;
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(*pose.rotation());
    let last_from_first = Rigid3::new(rotation, *pose.translation());
    let (explained, inlier_cost) = costs(&bundle);
    // A motion that explains fewer corners must not win by that.
    let mut corner_costs = vec![OUTLIER_COST; candidate.points.len()];
    for (i, cost) in index.iter().zip(explained) {
        corner_costs[*i] = cost;
    }
    let cost = corner_costs.iter().sum::<f64>() / corner_costs.len().max(1) as f64;
    Some(VerifiedStart { last_from_first, points, corner_costs, cost, inlier_cost })
}

/// Solves, leaves out the corners that some view contradicts, and solves again. Says which those are.
fn solve_without_outliers(bundle: &mut Bundle) -> Vec<bool> {
    let all = bundle.observations.clone();
    let mut is_outlier = vec![false; bundle.points.len()];
    for most_sigmas in MOST_SIGMAS {
        bundle.solve(&BundleSettings { max_iterations: 12, huber: 2.45 });
        is_outlier.fill(false);
        for observation in &all {
            let is_explained = bundle.residual(observation).is_some_and(|error| error.norm() < most_sigmas);
            is_outlier[observation.point] |= !is_explained;
        }
        bundle.observations = all.iter().filter(|o| !is_outlier[o.point]).copied().collect();
    }
    bundle.solve(&BundleSettings { max_iterations: 12, huber: 2.45 });
    bundle.observations = all;
    is_outlier
}

/// Mean cost of the observations of each point, and of all observations that are explained.
fn costs(bundle: &Bundle) -> (Vec<f64>, f64) {
    let mut of_points = vec![(0.0, 0.0); bundle.points.len()];
    let (mut inlier_sum, mut num_inliers) = (0.0, 0);
    for observation in &bundle.observations {
        let cost = bundle.residual(observation).map_or(OUTLIER_COST, |error| 0.5 * error.norm_squared());
        let (sum, num) = &mut of_points[observation.point];
        (*sum, *num) = (*sum + cost.min(OUTLIER_COST), *num + 1.0);
        if cost < OUTLIER_COST {
            inlier_sum += cost;
            num_inliers += 1;
        }
    }
    let of_points = of_points.iter().map(|(sum, num)| sum / f64::max(*num, 1.0)).collect();
    (of_points, inlier_sum / f64::from(num_inliers.max(1)))
}
