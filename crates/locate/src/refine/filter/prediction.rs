//! How a hypothesis moves on: by the odometry, through its gaps, and without any.

use nalgebra::{Matrix4, Vector3, Vector4};
use visloc_core::geom::{PlanarPose, angle};

use super::{Covariance, DRIFT, Gap, MOTION, PoseFilter, SLOW, STATE, State, slow_noise, square};
use crate::{odometer::Odometry, refine::RefinementConfig};

/// Without odometry: speed to the sides beside the speed ahead.
const SIDEWAYS: f64 = 0.5;

impl PoseFilter {
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
}

/// Covariance of the errors of an odometry, or of the velocity without one, before images have shown anything of them.
pub(super) fn unknown_motion(has_odometry: bool, config: &RefinementConfig) -> Matrix4<f64> {
    let spreads = if has_odometry {
        let scale = config.odometry_scale_error;
        [scale, scale, scale, config.odometry_drift_rad_per_m]
    } else {
        let (speed, turn) = (config.speed_m_per_s, config.turn_rad_per_s);
        [speed, SIDEWAYS * speed, turn, 0.0]
    };
    Matrix4::from_diagonal(&Vector4::from(spreads).map(square))
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
