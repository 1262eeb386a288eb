//! The refinement: Levenberg-Marquardt over the camera and all poses.

use nalgebra::{Matrix6, Point2, Point3, Rotation3, SMatrix, SVector, Vector2, Vector3, Vector6};
use visloc_core::geom::{CameraFrame, Rigid3, renormalized};

use super::{Intrinsics, NUM_INTRINSICS};
use crate::BoardFrame;

/// Pose of the board in front of the camera.
pub type CameraFromBoard = Rigid3<CameraFrame, BoardFrame>;

/// A corner and where it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// On the board, meters.
    pub point_in_board: Point3<f64>,
    /// In the image, pixels.
    pub px: Point2<f64>,
}

/// When to stop, and what an outlier is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefineSettings {
    /// Most steps.
    pub max_iterations: usize,
    /// Errors above this count linearly (Huber), pixels.
    pub huber_px: f64,
}

/// Where the refinement ended.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The camera.
    pub intrinsics: Intrinsics,
    /// Pose of each picture.
    pub poses: Vec<CameraFromBoard>,
    /// Covariance of the intrinsics for residuals with a standard deviation of one pixel; `None` if the pictures leave a
    /// parameter undetermined.
    pub unit_covariance: Option<SMatrix<f64, NUM_INTRINSICS, NUM_INTRINSICS>>,
    /// Steps that were taken.
    pub iterations: usize,
}

type CameraBlock = SMatrix<f64, NUM_INTRINSICS, NUM_INTRINSICS>;
type CrossBlock = SMatrix<f64, NUM_INTRINSICS, 6>;
type CameraVector = SVector<f64, NUM_INTRINSICS>;

/// Damping at the start, and when nothing can be gained any more.
const DAMPING: (f64, f64) = (1e-4, 1e10);
/// Relative gain below which the refinement has converged.
const CONVERGED: f64 = 1e-11;

/// One picture's part of the normal equations.
struct ViewBlock {
    pose: Matrix6<f64>,
    cross: CrossBlock,
    gradient: Vector6<f64>,
}

/// Normal equations: an arrow of one camera and many poses that know nothing of each other.
struct Normal {
    camera: CameraBlock,
    gradient: CameraVector,
    views: Vec<ViewBlock>,
}

/// Minimizes the Huber cost of all residuals over camera and poses.
///
/// Source: Marquardt 1963; the poses are eliminated as in Triggs et al., "Bundle adjustment: a modern synthesis", 2000,
/// section 6.1.
pub fn refine(
    mut intrinsics: Intrinsics,
    mut poses: Vec<CameraFromBoard>,
    views: &[Vec<Observation>],
    settings: &RefineSettings,
) -> Refined {
    let mut damping = DAMPING.0;
    let mut cost = total_cost(&intrinsics, &poses, views, settings.huber_px);
    let mut iterations = 0;
    while iterations < settings.max_iterations && damping < DAMPING.1 {
        iterations += 1;
        let normal = linearize(&intrinsics, &poses, views, settings.huber_px);
        let mut gain = 0.0;
        while damping < DAMPING.1 {
            if let Some((camera_step, pose_steps)) = solve(&normal, damping) {
                let mut tried = intrinsics;
                tried.values += camera_step;
                let tried_poses: Vec<_> =
                    poses.iter().zip(&pose_steps).map(|(pose, step)| moved(pose, step)).collect();
                let tried_cost = total_cost(&tried, &tried_poses, views, settings.huber_px);
                if tried_cost < cost {
                    gain = (cost - tried_cost) / cost;
                    (intrinsics, poses, cost) = (tried, tried_poses, tried_cost);
                    damping = (damping * 0.2).max(1e-12);
                    break;
                }
            }
            damping *= 6.0;
        }
        if gain < CONVERGED {
            break;
        }
    }
    let normal = linearize(&intrinsics, &poses, views, f64::INFINITY);
    Refined { unit_covariance: covariance(&normal, &intrinsics), intrinsics, poses, iterations }
}

/// The pose turned and shifted by (shift, turn) in the camera's frame.
fn moved(pose: &CameraFromBoard, step: &Vector6<f64>) -> CameraFromBoard {
    let turn = Rotation3::from_scaled_axis(Vector3::new(step[3], step[4], step[5]));
    let shift = Vector3::new(step[0], step[1], step[2]);
    // Made orthogonal again: hundreds of products would drift.
    let rotation = renormalized(turn * Rotation3::from_matrix_unchecked(*pose.rotation()));
    Rigid3::new(rotation, turn * pose.translation() + shift)
}

/// Residual, pixels; `None` behind the camera.
pub(crate) fn residual(
    intrinsics: &Intrinsics,
    pose: &CameraFromBoard,
    o: &Observation,
) -> Option<Vector2<f64>> {
    Some(o.px.coords - intrinsics.project(&pose.transform(&o.point_in_board).coords)?)
}

fn total_cost(
    intrinsics: &Intrinsics,
    poses: &[CameraFromBoard],
    views: &[Vec<Observation>],
    huber_px: f64,
) -> f64 {
    if intrinsics.values[0] <= 0.0 || intrinsics.values[1] <= 0.0 {
        return f64::INFINITY;
    }
    let mut cost = 0.0;
    for (pose, view) in poses.iter().zip(views) {
        for o in view {
            let Some(error) = residual(intrinsics, pose, o) else { return f64::INFINITY };
            let norm = error.norm();
            cost += if norm > huber_px { huber_px * (norm - 0.5 * huber_px) } else { 0.5 * norm * norm };
        }
    }
    if cost.is_finite() { cost } else { f64::INFINITY }
}

fn linearize(
    intrinsics: &Intrinsics,
    poses: &[CameraFromBoard],
    views: &[Vec<Observation>],
    huber_px: f64,
) -> Normal {
    let mut normal = Normal {
        camera: CameraBlock::zeros(),
        gradient: CameraVector::zeros(),
        views: Vec::with_capacity(poses.len()),
    };
    for (pose, view) in poses.iter().zip(views) {
        let mut block =
            ViewBlock { pose: Matrix6::zeros(), cross: CrossBlock::zeros(), gradient: Vector6::zeros() };
        for o in view {
            let p = pose.transform(&o.point_in_board).coords;
            let Some(l) = intrinsics.linearize(&p) else { continue };
            let error = o.px.coords - l.px;
            let weight = if error.norm() > huber_px { huber_px / error.norm() } else { 1.0 };
            // d point / d (shift, turn) = [I, -[p]x]
            let mut by_pose = SMatrix::<f64, 2, 6>::zeros();
            by_pose.fixed_view_mut::<2, 3>(0, 0).copy_from(&l.by_point);
            by_pose.fixed_view_mut::<2, 3>(0, 3).copy_from(&(-l.by_point * p.cross_matrix()));
            let weighted = by_pose.transpose() * weight;
            block.pose += weighted * by_pose;
            block.gradient += weighted * error;
            let camera = l.by_intrinsics.transpose() * weight;
            block.cross += camera * by_pose;
            normal.camera += camera * l.by_intrinsics;
            normal.gradient += camera * error;
        }
        normal.views.push(block);
    }
    normal
}

/// Steps of camera and poses; `None` if the damped equations have no solution.
fn solve(normal: &Normal, damping: f64) -> Option<(CameraVector, Vec<Vector6<f64>>)> {
    let mut reduced = normal.camera;
    for i in 0..NUM_INTRINSICS {
        // A parameter that the model does not have stays where it is.
        reduced[(i, i)] += reduced[(i, i)] * damping + f64::from(u8::from(reduced[(i, i)] == 0.0));
    }
    let mut gradient = normal.gradient;
    let mut inverses = Vec::with_capacity(normal.views.len());
    for view in &normal.views {
        let mut pose = view.pose;
        for i in 0..6 {
            pose[(i, i)] += pose[(i, i)] * damping + 1e-12;
        }
        let inverse = pose.try_inverse()?;
        reduced -= view.cross * inverse * view.cross.transpose();
        gradient -= view.cross * inverse * view.gradient;
        inverses.push(inverse);
    }
    let camera_step = reduced.cholesky()?.solve(&gradient);
    let steps = normal.views.iter().zip(&inverses);
    let steps: Vec<_> = steps
        .map(|(view, inverse)| inverse * (view.gradient - view.cross.transpose() * camera_step))
        .collect();
    let is_finite = camera_step.iter().chain(steps.iter().flatten()).all(|v| v.is_finite());
    is_finite.then_some((camera_step, steps))
}

/// Inverse of the reduced camera block.
fn covariance(normal: &Normal, intrinsics: &Intrinsics) -> Option<CameraBlock> {
    let mut reduced = normal.camera;
    for view in &normal.views {
        reduced -= view.cross * view.pose.try_inverse()? * view.cross.transpose();
    }
    for i in intrinsics.num_parameters()..NUM_INTRINSICS {
        reduced[(i, i)] = 1.0;
    }
    // Scaled to ones first: pixels and coefficients differ by many orders of magnitude.
    let scale = reduced.diagonal().map(|v| v.max(1e-300).sqrt().recip());
    let scaled = CameraBlock::from_fn(|i, j| reduced[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    let covariance = CameraBlock::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]);
    covariance.iter().all(|v| v.is_finite()).then_some(covariance)
}
