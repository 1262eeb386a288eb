//! The camera's direction and height.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use visloc_core::geom::PlanarPose;

use super::{DriveRecord, MountCorrection, RobotCalibrationError, record::MappedView};
use crate::observation::features::{CameraState, FeatureModel, Residual};

/// How the camera is mounted, against what the robot reports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountEstimate {
    /// The correction.
    pub correction: MountCorrection,
    /// Standard deviations of pitch, roll (degrees) and height (meters), from the scatter of the views; errors that all views
    /// of a drive have in common are not in them.
    pub standard_deviations: [f64; 3],
    /// Root of the mean squared distance of border pixels from the map, pixels, before and after.
    pub rms_px: (f64, f64),
    /// Views that were used.
    pub num_views: usize,
}

/// Images that must tell of the mount: a handful from one place leaves tilt and height open together.
const MIN_VIEWS: usize = 20;
/// Gates of the rounds, pixels.
const GATES_PX: [f64; 8] = [25.0, 20.0, 15.0, 12.0, 10.0, 8.0, 8.0, 8.0];
/// What is known before: pose of each view, meters and radians; tilt, radians; height, meters.
const POSE_SPREAD: [f64; 3] = [0.1, 0.1, 0.05];
const TILT_SPREAD_RAD: f64 = 0.1;
const HEIGHT_SPREAD_M: f64 = 0.2;
/// Neighboring pixels err alike: a view counts as so many pixels of this noise, as in the tracks.
const INDEPENDENT_PIXELS: f64 = 12.0;

/// Parameters: tilt about the camera's x and z, radians; height, meters. The turn about y is left out: it is the robot's heading.
type Mount = Vector3<f64>;

/// Normal equations of one view, its pose taken out.
struct Reduced {
    hessian: Matrix3<f64>,
    gradient: Vector3<f64>,
    pose_step: Vector3<f64>,
    pose_by_mount: Matrix3<f64>,
    squares: (f64, f64),
}

/// Fits tilt and height to all views at once; each view's pose is free within its uncertainty.
///
/// # Errors
/// If there are too few views.
pub fn solve_mount(
    record: &DriveRecord,
    model: &mut dyn FeatureModel,
) -> Result<MountEstimate, RobotCalibrationError> {
    if record.views.len() < MIN_VIEWS {
        return Err(RobotCalibrationError::FewViews { expected: MIN_VIEWS, found: record.views.len() });
    }
    let mut mount = Mount::zeros();
    let mut poses: Vec<Vector3<f64>> =
        record.views.iter().map(|view| vector(&view.world_from_robot)).collect();
    let before = rms_px(record, &poses, &mount, model);
    let prior = Vector3::new(TILT_SPREAD_RAD, TILT_SPREAD_RAD, HEIGHT_SPREAD_M).map(|s| s.powi(-2));
    let mut covariance = Matrix3::identity();
    for gate_px in GATES_PX {
        let mut hessian = Matrix3::from_diagonal(&prior);
        let mut gradient = -prior.component_mul(&mount);
        let mut scatter = Matrix3::zeros();
        let reduced: Vec<Reduced> = record
            .views
            .iter()
            .zip(&poses)
            .map(|(view, pose)| reduce(view, pose, &mount, gate_px, model))
            .collect();
        for view in &reduced {
            hessian += view.hessian;
            gradient += view.gradient;
            scatter += view.gradient * view.gradient.transpose();
        }
        let Some(inverse) = hessian.try_inverse() else { break };
        let step = inverse * gradient;
        // The scatter of the views' own wishes, instead of a noise that is only believed.
        covariance = inverse * (scatter + Matrix3::from_diagonal(&prior)) * inverse;
        mount += step;
        for (pose, view) in poses.iter_mut().zip(&reduced) {
            *pose += view.pose_step - view.pose_by_mount * step;
        }
    }
    let deviation = |i: usize| covariance[(i, i)].max(0.0).sqrt();
    Ok(MountEstimate {
        correction: correction(&mount),
        standard_deviations: [deviation(0).to_degrees(), deviation(1).to_degrees(), deviation(2)],
        rms_px: (before, rms_px(record, &poses, &mount, model)),
        num_views: record.views.len(),
    })
}

fn vector(pose: &PlanarPose) -> Vector3<f64> {
    Vector3::new(pose.x_m, pose.y_m, pose.yaw_rad)
}

fn correction(mount: &Mount) -> MountCorrection {
    MountCorrection::from_tilt(mount.x, mount.y, mount.z)
}

/// Residuals of all features of a view, in their order.
fn residuals(
    view: &MappedView,
    pose: &Vector3<f64>,
    mount: &Mount,
    gate_px: f64,
    model: &mut dyn FeatureModel,
) -> Vec<Option<Residual>> {
    let mut percept = view.percept.clone();
    percept.robot_from_camera = correction(mount).apply(&percept.robot_from_camera);
    model.condition_on(&percept);
    let state = CameraState::reported(PlanarPose::new(pose.x, pose.y, pose.z));
    let mut found = Vec::new();
    model.visit_matches(&state, gate_px, 1, &mut |feature| found.push(feature.residual));
    found
}

fn reduce(
    view: &MappedView,
    pose: &Vector3<f64>,
    mount: &Mount,
    gate_px: f64,
    model: &mut dyn FeatureModel,
) -> Reduced {
    let (mut hessian, mut gradient) = (SMatrix::<f64, 6, 6>::zeros(), SVector::<f64, 6>::zeros());
    let (mut total, mut squares) = (0.0, (0.0, 0.0));
    for residual in residuals(view, pose, mount, gate_px, model).into_iter().flatten() {
        let error_px = residual.error_px;
        let weight = residual.weight(gate_px);
        // The turn about y is the robot's heading.
        let j = SVector::<f64, 6>::from_fn(|i, _| residual.jacobian[[0, 1, 2, 3, 5, 6][i]]);
        hessian += j * j.transpose() * weight;
        gradient -= j * (weight * error_px);
        total += weight;
        squares.0 += weight * error_px.powi(2);
        squares.1 += weight;
    }
    let scale = (INDEPENDENT_PIXELS / total.max(1e-9)).min(1.0);
    hessian *= scale;
    gradient *= scale;
    let off = pose - vector(&view.world_from_robot);
    for i in 0..3 {
        let information = POSE_SPREAD[i].powi(-2);
        hessian[(i, i)] += information;
        gradient[i] -= information * off[i];
    }
    let pose_block: Matrix3<f64> = hessian.fixed_view::<3, 3>(0, 0).into_owned();
    let cross: Matrix3<f64> = hessian.fixed_view::<3, 3>(0, 3).into_owned();
    let inverse = pose_block.try_inverse().unwrap_or_else(Matrix3::zeros);
    let pose_gradient: Vector3<f64> = gradient.fixed_rows::<3>(0).into_owned();
    Reduced {
        hessian: hessian.fixed_view::<3, 3>(3, 3) - cross.transpose() * inverse * cross,
        gradient: gradient.fixed_rows::<3>(3) - cross.transpose() * inverse * pose_gradient,
        pose_step: inverse * pose_gradient,
        pose_by_mount: inverse * cross,
        squares,
    }
}

fn rms_px(record: &DriveRecord, poses: &[Vector3<f64>], mount: &Mount, model: &mut dyn FeatureModel) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (view, pose) in record.views.iter().zip(poses) {
        let squares = reduce(view, pose, mount, GATES_PX[GATES_PX.len() - 1], model).squares;
        sum += squares.0;
        total += squares.1;
    }
    (sum / f64::max(total, 1e-9)).sqrt()
}
