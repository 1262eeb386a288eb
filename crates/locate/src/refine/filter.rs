//! The filter of one track.

use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3, Vector4};
use visloc_core::geom::{PlanarPose, angle};

use super::{RefinementConfig, mount::Mount, other_mounts::OtherMounts};
use crate::{
    observation::features::{CameraState, CameraVector, FeatureModel},
    odometer::Odometry,
};

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

/// Group of the features that belong to landmarks.
const LANDMARKS: usize = 1;

pub(super) type State = SVector<f64, STATE>;
pub(super) type Covariance = SMatrix<f64, STATE, STATE>;
pub(super) type CameraMatrix = SMatrix<f64, CAMERA, CAMERA>;

/// The features that a pose explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Agreement {
    /// Shares of the features of each group that are as good as all.
    full_shares: [f64; 2],
    /// Sum of the agreements and number of the features, for each group.
    groups: [(f64, f64); 2],
}

/// What fits one image best.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImageFit {
    /// Pose, tilt and height.
    pub at: CameraVector,
    /// Information of this image alone about them.
    pub information: CameraMatrix,
    /// The features that they explain.
    pub agreement: Agreement,
}

/// Coarse steps of a fit take one feature in so many, and so does the agreement at its end.
const COARSE_STRIDE: usize = 3;
const JUDGE_STRIDE: usize = 2;
/// Without odometry: speed to the sides beside the speed ahead.
const SIDEWAYS: f64 = 0.5;
/// Shift in an image of ordinary size and angle of view by a step of one meter, and by a turn.
const PX_PER_M: f64 = 100.0;
const PX_PER_RAD: f64 = 370.0;
/// Fewer features of a landmark than this neither confirm nor contradict.
const MIN_LANDMARK_FEATURES: f64 = 3.0;

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
struct Fit {
    information: CameraMatrix,
    gradient: CameraVector,
    agreement: Agreement,
}

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

    /// The odometry has stopped: what it has shown of its errors is set aside, and the robot goes on as one without. Most probably it has
    /// the velocity that it had, but it may stop or turn at once, so that nothing else is known of it.
    fn begin_gap(&mut self, velocity: &Vector3<f64>, config: &RefinementConfig) {
        let m = self.mean.fixed_rows::<4>(MOTION).into_owned();
        let learned = (m, self.covariance.fixed_view::<4, 4>(MOTION, MOTION).into_owned());
        let length = velocity.x.hypot(velocity.y);
        let body = Vector4::new(
            velocity.x * (1.0 + m[0]),
            velocity.y * (1.0 + m[1]),
            velocity.z * (1.0 + m[2]) + m[3] * length,
            0.0,
        );
        self.gap = Some(Box::new(Gap { learned, before: Some(self.clone()) }));
        self.has_odometry = false;
        self.set_motion(&body, &unknown_motion(false, config));
    }

    /// The odometry is there again.
    fn end_gap(&mut self) {
        if let Some(gap) = self.gap.take() {
            self.has_odometry = true;
            self.set_motion(&gap.learned.0, &gap.learned.1);
        }
    }

    /// Moves on by what the odometry says, or by the time passed without it.
    pub fn predict(&mut self, odometry: &Odometry, secs: f64, config: &RefinementConfig) {
        match odometry {
            Odometry::Moved(motion) => self.move_by(motion, secs, config),
            Odometry::First => self.move_by(&PlanarPose::default(), secs, config),
            Odometry::Missing { velocity, .. } => self.follow(velocity, secs, config),
            Odometry::Bridged { motion, secs: since, velocity, .. } => {
                self.follow(velocity, secs, config);
                let before = self.gap.as_mut().and_then(|gap| gap.before.take());
                self.end_gap();
                // Images may have followed the robot through the gap better than the odometry tells what happened.
                if let Some(mut told) = before {
                    told.move_by(motion, *since, config);
                    if told.spread_m() < self.spread_m() {
                        *self = told;
                    }
                }
            }
            Odometry::Without => {
                if self.has_odometry {
                    self.forget_motion(false, config);
                }
                self.let_pass(secs, config);
            }
        }
    }

    /// Moves on by the motion that the odometry tells, seen from the robot.
    fn move_by(&mut self, o: &PlanarPose, secs: f64, config: &RefinementConfig) {
        self.end_gap();
        if !self.has_odometry {
            self.forget_motion(true, config);
        }
        let (sin, cos) = self.mean[2].sin_cos();
        let mut change = Covariance::identity();
        let mut noise = State::zeros();
        let m = self.mean.fixed_rows::<4>(MOTION).into_owned();
        let length = o.x_m.hypot(o.y_m);
        for (axis, step) in [(0, (cos * o.x_m, sin * o.x_m)), (1, (-sin * o.y_m, cos * o.y_m))] {
            change[(0, MOTION + axis)] = step.0;
            change[(1, MOTION + axis)] = step.1;
        }
        change[(2, MOTION + 2)] = o.yaw_rad;
        change[(2, DRIFT)] = length;
        let position = config.odometry_noise_m.powi(2) * (length + 0.05 * o.yaw_rad.abs());
        noise[0] = position;
        noise[1] = position;
        noise[2] = config.odometry_noise_rad.powi(2) * length
            + config.odometry_turn_noise_rad.powi(2) * o.yaw_rad.abs();
        let motion = Vector3::new(
            o.x_m * (1.0 + m[0]),
            o.y_m * (1.0 + m[1]),
            o.yaw_rad * (1.0 + m[2]) + m[3] * length,
        );
        self.apply(&motion, change, noise, secs, config);
    }

    /// Moves on through a gap of the odometry.
    fn follow(&mut self, velocity: &Vector3<f64>, secs: f64, config: &RefinementConfig) {
        if self.has_odometry {
            self.begin_gap(velocity, config);
        }
        self.let_pass(secs, config);
    }

    /// Moves on by the velocity of the body.
    fn let_pass(&mut self, secs: f64, config: &RefinementConfig) {
        let (sin, cos) = self.mean[2].sin_cos();
        let mut change = Covariance::identity();
        let mut noise = State::zeros();
        let m = self.mean.fixed_rows::<4>(MOTION).into_owned();
        change[(0, MOTION)] = cos * secs;
        change[(1, MOTION)] = sin * secs;
        change[(0, MOTION + 1)] = -sin * secs;
        change[(1, MOTION + 1)] = cos * secs;
        change[(2, MOTION + 2)] = secs;
        let kept = (-secs / config.speed_secs).exp();
        let (speed, turn) = (config.speed_m_per_s, config.turn_rad_per_s);
        for (i, spread) in [speed, SIDEWAYS * speed, turn].into_iter().enumerate() {
            change[(MOTION + i, MOTION + i)] = kept;
            noise[MOTION + i] = spread * spread * (1.0 - kept * kept);
            self.mean[MOTION + i] *= kept;
        }
        self.apply(&Vector3::new(m[0] * secs, m[1] * secs, m[2] * secs), change, noise, secs, config);
    }

    /// Applies a motion of the robot, seen from it. `change` lacks what follows from the heading and from the time.
    fn apply(
        &mut self,
        motion: &Vector3<f64>,
        mut change: Covariance,
        mut noise: State,
        secs: f64,
        config: &RefinementConfig,
    ) {
        let (sin, cos) = self.mean[2].sin_cos();
        change[(0, 2)] = -sin * motion.x - cos * motion.y;
        change[(1, 2)] = cos * motion.x - sin * motion.y;
        let kept = (-secs / config.tilt_bias_secs).exp();
        for (i, spread) in slow_noise(config).iter().enumerate() {
            change[(SLOW + i, SLOW + i)] = kept;
            noise[SLOW + i] = square(*spread) * (1.0 - kept * kept);
            self.mean[SLOW + i] *= kept;
        }
        self.mean[0] += cos * motion.x - sin * motion.y;
        self.mean[1] += sin * motion.x + cos * motion.y;
        self.mean[2] = angle::wrap(self.mean[2] + motion.z);
        self.covariance = moved(&self.covariance, &change) + Covariance::from_diagonal(&noise);
        self.others.change(&change);
    }

    /// Images have shown nothing for `from_secs` and now for `to_secs`: the robot may have moved slowly in a way that its odometry does not
    /// notice, so that the standard deviation grows with the time. In the time in which the reliability fades the position becomes as
    /// uncertain as one that is relied upon less, and the heading as much as moves things by that at one meter.
    pub fn drift(&mut self, from_secs: f64, to_secs: f64, config: &RefinementConfig) {
        let sigma = |secs: f64| config.reliable_spread_m * secs / config.reliability.blind_secs;
        let variance = square(sigma(to_secs)) - square(sigma(from_secs));
        for i in 0..SLOW {
            self.covariance[(i, i)] += variance;
        }
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

/// Covariance of the errors of an odometry, or of the velocity without one, before images have shown anything of them.
fn unknown_motion(has_odometry: bool, config: &RefinementConfig) -> Matrix4<f64> {
    let spreads = if has_odometry {
        let scale = config.odometry_scale_error;
        [scale, scale, scale, config.odometry_drift_rad_per_m]
    } else {
        let (speed, turn) = (config.speed_m_per_s, config.turn_rad_per_s);
        [speed, SIDEWAYS * speed, turn, 0.0]
    };
    Matrix4::from_diagonal(&Vector4::from(spreads).map(square))
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

/// `change * covariance * change^T`, without what is zero in every change: hundreds of tracks are moved on for each image.
fn moved(covariance: &Covariance, change: &Covariance) -> Covariance {
    /// What is beside the diagonal of a change: rows and their columns.
    const BESIDE: [(usize, &[usize]); 3] =
        [(0, &[2, MOTION, MOTION + 1]), (1, &[2, MOTION, MOTION + 1]), (2, &[MOTION + 2, DRIFT])];
    let mut half = *covariance;
    for (mut column, from) in half.column_iter_mut().zip(covariance.column_iter()) {
        column.component_mul_assign(&change.diagonal());
        for (row, others) in BESIDE {
            for other in others {
                column[row] += change[(row, *other)] * from[*other];
            }
        }
    }
    let mut both = half;
    for i in 0..STATE {
        both.column_mut(i).scale_mut(change[(i, i)]);
    }
    for (row, others) in BESIDE {
        for other in others {
            let share = half.column(*other) * change[(row, *other)];
            let mut column = both.column_mut(row);
            column += share;
        }
    }
    both
}

fn square(value: f64) -> f64 {
    value * value
}

/// Matches one feature in `stride` from one state and adds up their normal equations.
fn fit(
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
    let soft_px = gate_px / 3.0;
    model.visit_matches(&state, gate_px, stride, &mut |feature| {
        let group = &mut fit.agreement.groups[feature.group];
        group.1 += 1.0;
        let Some(residual) = feature.residual else {
            group.0 += feature.unmatched_agreement;
            return;
        };
        let error2 = residual.error_px.powi(2);
        group.0 += (-0.5 * error2 / config.agreement_px.powi(2)).exp().max(feature.unmatched_agreement);
        // Geman and McClure's weight: what is far off does not pull.
        let weight = (1.0 + error2 / soft_px.powi(2)).powi(-2);
        total_weight += weight;
        let weighted = residual.jacobian * weight;
        fit.information += weighted * residual.jacobian.transpose();
        fit.gradient -= weighted * residual.error_px;
    });
    let independent = (config.max_independent_pixels / total_weight.max(1e-9)).min(1.0);
    let scale = independent / config.pixel_noise_px.powi(2);
    fit.information *= scale;
    fit.gradient *= scale;
    fit
}
