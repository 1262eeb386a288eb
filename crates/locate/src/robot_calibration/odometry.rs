//! The scale of the odometry.

use nalgebra::{Matrix4, SMatrix, Vector3, Vector4};
use visloc_core::geom::{PlanarPose, angle};

use super::{DriveRecord, OdometryCorrection, RobotCalibrationError, record::DrivePoint};

/// How the odometry has to be corrected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryEstimate {
    /// The correction.
    pub correction: OdometryCorrection,
    /// Standard deviations of the three factors and of the drift (degrees per meter).
    pub standard_deviations: [f64; 4],
    /// Stretches of motion that were used.
    pub num_stretches: usize,
}

/// Stretches of motion that must be there: more than twice the three scales that they tell.
const MIN_STRETCHES: usize = 8;
/// A stretch ends after so much motion, meters and radians, or time, seconds.
const STRETCH: (f64, f64, f64) = (0.6, 0.9, 6.0);
/// A stretch with less motion tells nothing, meters and radians.
const MIN_MOTION: (f64, f64) = (0.1, 0.15);
/// A pause between frames that ends a stretch, seconds.
const MAX_GAP_SECS: f64 = 0.5;
/// Errors of the difference of two poses, meters and radians.
const NOISE: [f64; 3] = [0.03, 0.03, 0.02];
/// What is known before: factors, drift in radians per meter.
const SPREAD: [f64; 4] = [0.3, 0.3, 0.3, 0.2];
/// Stretches that are so many standard deviations off count less: somebody may have carried the robot.
const HUBER: f64 = 2.0;
const ROUNDS: usize = 12;

/// Consecutive reported motions and what they were in truth.
struct Stretch {
    reported: Vec<PlanarPose>,
    real: PlanarPose,
}

/// Fits the factors of the reported motion to the poses.
///
/// # Errors
/// If there is no odometry, or the robot hardly moved while it knew its place.
pub fn solve_odometry(record: &DriveRecord) -> Result<OdometryEstimate, RobotCalibrationError> {
    if record.points.iter().all(|point| point.odometry.is_none()) {
        return Err(RobotCalibrationError::NoOdometry);
    }
    let stretches = stretches(&record.points);
    if stretches.len() < MIN_STRETCHES {
        return Err(RobotCalibrationError::LittleMotion { expected: MIN_STRETCHES, found: stretches.len() });
    }
    let start = Vector4::new(1.0, 1.0, 1.0, 0.0);
    let mut state = start;
    let mut hessian = Matrix4::identity();
    let mut squares = 0.0;
    for _ in 0..ROUNDS {
        let prior = Vector4::from(SPREAD).map(|s| s.powi(-2));
        hessian = Matrix4::from_diagonal(&prior);
        let mut gradient = prior.component_mul(&(start - state));
        squares = 0.0;
        for stretch in &stretches {
            let error = residual(stretch, &state);
            let jacobian = jacobian(stretch, &state);
            let weight = (HUBER / error.norm().max(1e-9)).min(1.0);
            hessian += jacobian.transpose() * jacobian * weight;
            gradient -= jacobian.transpose() * error * weight;
            squares += weight * error.norm_squared();
        }
        let Some(step) = hessian.cholesky().map(|c| c.solve(&gradient)) else { break };
        state += step;
        if step.norm() < 1e-9 {
            break;
        }
    }
    let noise = (squares / (3.0 * stretches.len() as f64 - 4.0).max(1.0)).sqrt();
    let covariance = hessian.try_inverse().unwrap_or_else(Matrix4::zeros);
    let deviation = |i: usize| noise * covariance[(i, i)].max(0.0).sqrt();
    Ok(OdometryEstimate {
        correction: correction(&state),
        standard_deviations: [deviation(0), deviation(1), deviation(2), deviation(3).to_degrees()],
        num_stretches: stretches.len(),
    })
}

fn correction(state: &Vector4<f64>) -> OdometryCorrection {
    OdometryCorrection { scale: [state.x, state.y, state.z], drift_deg_per_m: state.w.to_degrees() }
}

/// Cuts a drive at rests, gaps and places that are not known.
fn stretches(points: &[DrivePoint]) -> Vec<Stretch> {
    let mut stretches = Vec::new();
    let mut start: Option<(DrivePoint, PlanarPose)> = None;
    let mut reported: Vec<PlanarPose> = Vec::new();
    let (mut length_m, mut turn_rad) = (0.0, 0.0);
    for pair in points.windows(2) {
        let (Some(before), Some(odometry)) = (pair[0].odometry, pair[1].odometry) else {
            start = None;
            continue;
        };
        if pair[1].at.secs_since(pair[0].at) > MAX_GAP_SECS {
            start = None;
            continue;
        }
        let Some(from) = start.or_else(|| Some((pair[0], pair[0].world_from_robot?))) else { continue };
        if start.is_none() {
            reported.clear();
            (length_m, turn_rad) = (0.0, 0.0);
        }
        start = Some(from);
        let motion = odometry.relative_to(&before);
        length_m += motion.x_m.hypot(motion.y_m);
        turn_rad += motion.yaw_rad.abs();
        reported.push(motion);
        let secs = pair[1].at.secs_since(from.0.at);
        let is_long = length_m > STRETCH.0 || turn_rad > STRETCH.1 || secs > STRETCH.2;
        if !is_long {
            continue;
        }
        if let Some(to) = pair[1].world_from_robot
            && (length_m > MIN_MOTION.0 || turn_rad > MIN_MOTION.1)
        {
            stretches
                .push(Stretch { reported: std::mem::take(&mut reported), real: to.relative_to(&from.1) });
        }
        start = None;
    }
    stretches
}

/// Corrected odometry minus real motion, in standard deviations.
fn residual(stretch: &Stretch, state: &Vector4<f64>) -> Vector3<f64> {
    let correction = correction(state);
    let moved = stretch
        .reported
        .iter()
        .fold(PlanarPose::default(), |pose, motion| pose.compose(&correction.apply(motion)));
    let turn = angle::difference(moved.yaw_rad, stretch.real.yaw_rad);
    Vector3::new(moved.x_m - stretch.real.x_m, moved.y_m - stretch.real.y_m, turn)
        .component_div(&Vector3::from(NOISE))
}

fn jacobian(stretch: &Stretch, state: &Vector4<f64>) -> SMatrix<f64, 3, 4> {
    let column = |i: usize| {
        let mut step = Vector4::zeros();
        step[i] = 1e-5;
        (residual(stretch, &(state + step)) - residual(stretch, &(state - step))) / 2e-5
    };
    SMatrix::from_columns(&[column(0), column(1), column(2), column(3)])
}
