//! What is wrong with a robot, from a short drive on a known map: the direction and height of its camera, and the scale of its
//! odometry.
//!
//! The tracks of [`crate::refine`] follow slow errors of both while the robot moves, and pull them towards zero. What is wrong
//! *always* is estimated here over the whole drive at once: [`DriveRecord`] keeps what a run saw, [`solve_mount`] and
//! [`solve_odometry`] are batch least squares over it, and [`RobotCorrection`] corrects the frames of later runs.

mod correction;
mod mount;
mod odometry;
mod record;
#[cfg(test)]
mod tests;

pub use correction::{MountCorrection, OdometryCorrection, OdometryCorrector, RobotCorrection};
pub use mount::{MountEstimate, solve_mount};
pub use odometry::{OdometryEstimate, solve_odometry};
pub use record::{DriveRecord, RobotCalibrationError};
