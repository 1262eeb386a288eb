//! Motion of a robot over the ground that it sees, without a map and without odometry.
//!
//! Where the camera is above the ground is known (`robot_from_camera`), so how the ground moves in the image is how the robot moves, in
//! meters: two images are aligned by the brightness of the ground in both, as the poses of SLAM are by image alignment
//! ([`crate::track`]), with the ground in place of landmarks. Carpet, wood and lines do; walls and robots are outliers.

mod align;

use align::{Aligner, Fit, View};
use nalgebra::Vector3;
use visloc_core::{Frame, Timestamp, geom::PlanarPose};

/// Images that are farther apart show other ground, seconds.
const MAX_GAP_SECS: f64 = 0.5;
/// Without ground in view a robot is taken to go on as before, ever slower, with this time, seconds; as without odometry in the refinement ...
const SPEED_SECS: f64 = 1.5;
/// ... and after this its motion is unknown, seconds.
const MAX_BLIND_SECS: f64 = 0.5;
/// A motion is known if its standard deviation is below this times the time between the images: a third of a slow walk.
const MAX_SPREAD_M_PER_S: f64 = 0.12;
/// The same of a turn.
const MAX_SPREAD_RAD_PER_S: f64 = 0.12;
/// Brightness that changes by more than this times what is usual was not aligned: it is no ground, or another place of it.
const MAX_NOISE: f64 = 1.25;
/// A motion that differs by more from what was expected, in standard deviations, was not aligned either.
const MAX_SURPRISE: f64 = 3.0;
/// Share of an image in what is usual.
const FOLLOW: f64 = 0.05;

/// Follows the motion of a robot by the ground in its images.
#[derive(Debug, Clone, Default)]
pub struct GroundOdometer {
    last: Option<View>,
    odom_from_robot: PlanarPose,
    /// Ahead and to the left (m/s), turning (rad/s).
    velocity: Vector3<f64>,
    usual_noise: Option<f64>,
    blind_secs: f64,
    aligner: Aligner,
}

impl GroundOdometer {
    /// An odometer that has seen nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in an image of the robot's first camera; those of others change nothing. Returns the accumulated motion, `odom_from_robot`,
    /// or `None` while it is unknown: too little ground in view for half a second, or feet in the air.
    pub fn step(&mut self, frame: &Frame) -> Option<PlanarPose> {
        if !frame.may_stand() {
            self.last = None;
            return None;
        }
        if frame.camera_index > 0 {
            return self.at(frame.at);
        }
        let view = View::new(frame);
        let last = self.last.take().filter(|last| is_soon(last.at, view.at));
        if let Some(last) = last {
            let secs = view.at.secs_since(last.at);
            let guess = motion(&self.velocity, secs);
            let fit = self.aligner.align(&last, &view, &guess);
            let step = match fit.filter(|fit| self.is_known(fit, secs)) {
                Some(fit) => {
                    let usual = self.usual_noise.get_or_insert(fit.noise);
                    *usual += FOLLOW * (fit.noise - *usual);
                    let PlanarPose { x_m, y_m, yaw_rad } = fit.motion;
                    self.velocity = Vector3::new(x_m, y_m, yaw_rad) / secs;
                    self.blind_secs = 0.0;
                    fit.motion
                }
                None => {
                    // What stays is no accident: the light is another one.
                    self.usual_noise = self.usual_noise.map(|usual| usual * MAX_NOISE.powf(secs));
                    self.velocity *= (-secs / SPEED_SECS).exp();
                    self.blind_secs += secs;
                    guess
                }
            };
            self.odom_from_robot = self.odom_from_robot.compose(&step);
        } else {
            self.velocity = Vector3::zeros();
            self.blind_secs = 0.0;
        }
        self.last = Some(view);
        (self.blind_secs <= MAX_BLIND_SECS).then_some(self.odom_from_robot)
    }

    /// The motion until a time soon after the last image.
    fn at(&self, at: Timestamp) -> Option<PlanarPose> {
        let last = self.last.as_ref().filter(|last| self.blind_secs <= MAX_BLIND_SECS && last.at <= at)?;
        let secs = at.secs_since(last.at).min(MAX_GAP_SECS);
        Some(self.odom_from_robot.compose(&motion(&self.velocity, secs)))
    }

    fn is_known(&self, fit: &Fit, secs: f64) -> bool {
        fit.surprise < MAX_SURPRISE
            && fit.spread_m < MAX_SPREAD_M_PER_S * secs
            && fit.spread_rad < MAX_SPREAD_RAD_PER_S * secs
            && self.usual_noise.is_none_or(|usual| fit.noise < MAX_NOISE * usual)
    }
}

fn is_soon(last: Timestamp, at: Timestamp) -> bool {
    let secs = at.secs_since(last);
    secs > 0.0 && secs <= MAX_GAP_SECS
}

fn motion(velocity: &Vector3<f64>, secs: f64) -> PlanarPose {
    PlanarPose::new(velocity.x * secs, velocity.y * secs, velocity.z * secs)
}

#[cfg(test)]
mod tests;
