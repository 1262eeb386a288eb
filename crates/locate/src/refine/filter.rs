//! The filter of one track.

mod image_fit;
mod prediction;

use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3, Vector4};
use visloc_core::geom::{PlanarPose, angle};

pub(super) use self::image_fit::{Agreement, ImageFit, LANDMARKS};
use self::{
    image_fit::{Fit, fit},
    prediction::unknown_motion,
};
use super::{RefinementConfig, mount::Mount, other_mounts::OtherMounts};
use crate::observation::features::{CameraState, CameraVector, FeatureModel};

/// Length of the state: pose (3), slow error of the camera's tilt (3) and height (1), motion (4), constant error of its tilt (3).
pub(super) const STATE: usize = 14;
/// Length of what an image sees of it: pose, tilt and height.
pub(super) const CAMERA: usize = 7;
/// First of what changes slowly: three angles of the camera's tilt, then its height.
pub(super) const SLOW: usize = 3;
/// First of the motion parameters: with odometry the relative errors of its three axes, without it the velocity
/// of the body (m/s, m/s, rad/s).
const MOTION: usize = 7;
/// With odometry its systematic turn, radians per meter.
const DRIFT: usize = 10;
/// First of the three angles of the camera's constant error.
pub(super) const MOUNT: usize = 11;

pub(super) type State = SVector<f64, STATE>;
pub(super) type Covariance = SMatrix<f64, STATE, STATE>;
pub(super) type CameraMatrix = SMatrix<f64, CAMERA, CAMERA>;

/// Coarse steps of a fit take one feature in so many, and so does the agreement at its end.
const COARSE_STRIDE: usize = 3;
const JUDGE_STRIDE: usize = 2;
/// Shift in an image of ordinary size and angle of view by a step of one meter, and by a turn.
const PX_PER_M: f64 = 100.0;
const PX_PER_RAD: f64 = 370.0;
/// Pose, camera tilt and height, and motion of one hypothesis with their covariance.
#[derive(Debug, Clone)]
pub(super) struct PoseFilter {
    mean: State,
    covariance: Covariance,
    has_odometry: bool,
    /// The state has the constant error of the camera whose image it is; this is that of the others.
    others: OtherMounts,
    /// While samples of the odometry are missing.
    gap: Option<Box<Gap>>,
}

/// What is kept over a gap of the odometry.
#[derive(Debug, Clone)]
struct Gap {
    /// The errors of the odometry as they were known: scales and drift with their covariance.
    learned: (Vector4<f64>, Matrix4<f64>),
    /// The filter at the last sample, if it has been at this place since.
    before: Option<PoseFilter>,
}

impl PoseFilter {
    /// A filter around a rough pose, of a robot of whose camera this is known.
    pub fn new(pose: &PlanarPose, mount: &Mount, config: &RefinementConfig) -> Self {
        let mut mean = State::zeros();
        mean.fixed_rows_mut::<3>(0).copy_from(&Vector3::new(pose.x_m, pose.y_m, pose.yaw_rad));
        let mut filter = Self {
            mean,
            covariance: Covariance::zeros(),
            has_odometry: true,
            others: OtherMounts::default(),
            gap: None,
        };
        let (m, rad) = (config.birth_noise_m.powi(2), config.birth_noise_rad.powi(2));
        for (i, variance) in [m, m, rad].into_iter().enumerate() {
            filter.covariance[(i, i)] = variance;
        }
        let slow = Matrix4::from_diagonal(&slow_noise(config).map(square));
        filter.covariance.fixed_view_mut::<4, 4>(SLOW, SLOW).copy_from(&slow);
        filter.mean.fixed_rows_mut::<3>(MOUNT).copy_from(&mount.tilt_rad);
        filter.covariance.fixed_view_mut::<3, 3>(MOUNT, MOUNT).copy_from(&mount.covariance);
        filter.forget_motion(true, config);
        filter
    }

    /// What it has found out about the constant error of the camera.
    pub fn mount(&self) -> Mount {
        Mount {
            tilt_rad: self.mean.fixed_rows::<3>(MOUNT).into_owned(),
            covariance: self.covariance.fixed_view::<3, 3>(MOUNT, MOUNT).into_owned(),
        }
    }

    /// What it has found out about the constant errors of the other cameras.
    pub fn other_mounts(&self) -> impl Iterator<Item = (usize, Mount)> {
        self.others.iter()
    }

    /// The next image is of another camera than the last one, of which `mount` is known if it has taken none yet. `turn` takes the axes of the
    /// last camera to those of this one: what changes slowly is the tilt of the body, which all cameras share.
    pub fn look_through(&mut self, cameras: (usize, usize), turn: &Matrix3<f64>, mount: &Mount) {
        if let Some(before) = self.gap.as_mut().and_then(|gap| gap.before.as_mut()) {
            before.look_through(cameras, turn, mount);
        }
        let mut change = Covariance::identity();
        change.fixed_view_mut::<3, 3>(SLOW, SLOW).copy_from(turn);
        self.mean = change * self.mean;
        self.covariance = change * self.covariance * change.transpose();
        self.others.change(&change);
        self.others.look_through((&mut self.mean, &mut self.covariance), cameras, mount);
    }

    /// The same motion, slow tilt and height at another pose.
    pub fn moved_to(&self, pose: &PlanarPose, mount: &Mount, config: &RefinementConfig) -> Self {
        let mut filter = Self::new(pose, mount, config);
        filter.has_odometry = self.has_odometry;
        filter.gap = self.gap.as_ref().map(|gap| Box::new(Gap { learned: gap.learned, before: None }));
        filter.mean.fixed_rows_mut::<8>(SLOW).copy_from(&self.mean.fixed_rows::<8>(SLOW));
        filter
            .covariance
            .fixed_view_mut::<8, 8>(SLOW, SLOW)
            .copy_from(&self.covariance.fixed_view::<8, 8>(SLOW, SLOW));
        filter
    }

    pub fn pose(&self) -> PlanarPose {
        PlanarPose::new(self.mean[0], self.mean[1], self.mean[2])
    }

    /// Where the camera of the next image is expected.
    pub fn camera(&self) -> CameraState {
        let mut camera = self.mean.fixed_rows::<CAMERA>(0).into_owned();
        let mut turn = camera.fixed_rows_mut::<3>(SLOW);
        turn += self.mean.fixed_rows::<3>(MOUNT);
        CameraState::from(&camera)
    }

    pub fn x_m(&self) -> f64 {
        self.mean[0]
    }

    /// How improbable tilt and height of the camera are for a robot of which another filter knows them, or for one of which nothing
    /// is known: minus the logarithm of the probability density against its peak.
    pub fn bend(&self, robot: Option<&Self>, config: &RefinementConfig) -> f64 {
        let slow = |filter: &Self| filter.mean.fixed_rows::<4>(SLOW).into_owned();
        let difference = slow(self) - robot.map_or_else(Vector4::zeros, slow);
        0.5 * difference.component_div(&slow_noise(config)).norm_squared()
    }

    pub fn set_pose(&mut self, pose: &PlanarPose) {
        self.mean[0] = pose.x_m;
        self.mean[1] = pose.y_m;
        self.mean[2] = pose.yaw_rad;
        if let Some(gap) = &mut self.gap {
            gap.before = None;
        }
    }

    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// What is known of the errors of the odometry: scales ahead, to the side and of turns, and drift.
    #[cfg(test)]
    pub fn odometry_errors(&self) -> Vector4<f64> {
        self.gap.as_ref().map_or_else(|| self.mean.fixed_rows::<4>(MOTION).into_owned(), |gap| gap.learned.0)
    }

    /// Standard deviation of the position in its worst direction, meters.
    pub fn spread_m(&self) -> f64 {
        let c = &self.covariance;
        let (mean, half) = (f64::midpoint(c[(0, 0)], c[(1, 1)]), (c[(0, 0)] - c[(1, 1)]) / 2.0);
        (mean + half.hypot(c[(0, 1)])).max(0.0).sqrt()
    }

    /// About how far off in the image, by twice the standard deviation, things a few meters away are expected, pixels.
    pub fn spread_px(&self) -> f64 {
        2.0 * (PX_PER_M * self.spread_m() + PX_PER_RAD * self.covariance[(2, 2)].max(0.0).sqrt())
    }

    fn forget_motion(&mut self, has_odometry: bool, config: &RefinementConfig) {
        self.has_odometry = has_odometry;
        self.set_motion(&Vector4::zeros(), &unknown_motion(has_odometry, config));
    }

    fn set_motion(&mut self, mean: &Vector4<f64>, covariance: &Matrix4<f64>) {
        for i in MOTION..MOUNT {
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.others.forget(i);
        }
        self.mean.fixed_rows_mut::<4>(MOTION).copy_from(mean);
        self.covariance.fixed_view_mut::<4, 4>(MOTION, MOTION).copy_from(covariance);
    }

    /// Fits pose, tilt and height to the features of an image: one Gauss-Newton step for each gate.
    pub fn update(
        &mut self,
        model: &dyn FeatureModel,
        gates_px: &[f64],
        config: &RefinementConfig,
    ) -> ImageFit {
        let tilt_rad = self.mount().tilt_rad;
        self.update_from(&tilt_rad, model, gates_px, config)
    }

    /// The same; the first step supposes that the camera is turned so, a rotation vector in its frame, radians.
    pub fn update_from(
        &mut self,
        tilt_rad: &Vector3<f64>,
        model: &dyn FeatureModel,
        gates_px: &[f64],
        config: &RefinementConfig,
    ) -> ImageFit {
        let mut prior = self.mean.fixed_rows::<CAMERA>(0).into_owned();
        let mut at = prior;
        // The tilt of this image is the slow one and the constant one.
        let mut turn = at.fixed_rows_mut::<3>(SLOW);
        turn += tilt_rad;
        let mut turn = prior.fixed_rows_mut::<3>(SLOW);
        turn += self.mean.fixed_rows::<3>(MOUNT);
        // Covariance of the state with (pose, tilt and height of this image).
        let mut cross = self.covariance.fixed_columns::<CAMERA>(0).into_owned();
        let mut turn = cross.fixed_columns_mut::<3>(SLOW);
        turn += self.covariance.fixed_columns::<3>(MOUNT);
        let mut spread = cross.fixed_rows::<CAMERA>(0).into_owned();
        let mut turn = spread.fixed_rows_mut::<3>(SLOW);
        turn += cross.fixed_rows::<3>(MOUNT);
        spread += CameraMatrix::from_diagonal(&image_noise(config).map(square));
        let mut step = None;
        for (i, gate_px) in gates_px.iter().enumerate() {
            // Only the last step has to be exact.
            let stride = if i + 1 < gates_px.len() { COARSE_STRIDE } else { 1 };
            let fit = fit(model, &at, *gate_px, stride, config);
            let pull = fit.gradient + fit.information * (at - prior);
            let Some(solved) = (CameraMatrix::identity() + fit.information * spread).try_inverse() else {
                break;
            };
            at = prior + spread * (solved * pull);
            step = Some((solved * pull, solved * fit.information));
        }
        if let Some((pull, information)) = step {
            let correction = cross * pull;
            if correction.iter().all(|v| v.is_finite()) {
                self.mean += correction;
                self.mean[2] = angle::wrap(self.mean[2]);
                let covariance = self.covariance - cross * information * cross.transpose();
                self.covariance = (covariance + covariance.transpose()) * 0.5;
                self.others.learn(&cross, &pull, &information);
            }
        }
        let Fit { information, agreement, .. } = fit(model, &at, config.gate_px, JUDGE_STRIDE, config);
        ImageFit { at, information, agreement }
    }
}

/// Standard deviations of what changes slowly: tilt and height of the camera.
fn slow_noise(config: &RefinementConfig) -> Vector4<f64> {
    let tilt = config.tilt_bias_rad;
    Vector4::new(tilt, tilt, tilt, config.raise_bias_m)
}

/// Standard deviations of what changes with every image: place, tilt and height of the camera.
fn image_noise(config: &RefinementConfig) -> CameraVector {
    let (eye, tilt) = (config.eye_noise_m, config.tilt_noise_rad);
    CameraVector::from([eye, eye, 0.0, tilt, tilt, tilt, eye])
}

fn square(value: f64) -> f64 {
    value * value
}
