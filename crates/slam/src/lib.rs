//! Semi-direct monocular SLAM: where one calibrated camera is, and a sparse map of what it sees, from images alone.
//!
//! A frame flows through the folders in this order: [`image`] (pyramid; before it, what a rolling shutter bent is put right) -> [`start`] (the first two keyframes) or
//! [`track`] (pose by image alignment, matching of the local map, robust pose) -> [`mapping`] (new landmarks, depth
//! filters, bundle adjustment, culling), all on one [`map`]. [`recognize`] finds places that were seen before: for a camera that
//! is lost, and for [`atlas`], which closes loops and joins maps. [`Slam`] ties them together. [`SelfCalibrator`] finds a camera that nobody
//! has calibrated.
//!
//! Lengths are in map units: a monocular map has no scale, unless [`odometry`] gives it one. Pixels have their centers at integers.

pub mod atlas;
mod backfill;
pub mod config;
pub mod diagnosis;
pub mod feature;
mod frame_log;
mod front_end;
pub mod ground;
pub mod image;
pub mod lie;
pub mod map;
pub mod mapping;
pub mod odometry;
pub mod orb;
mod outcome;
pub mod patch;
pub mod recognize;
mod schedule;
mod self_calibration;
mod shutter;
pub mod solve;
pub mod start;
mod system;
mod timing;
pub mod track;

pub use config::{ConfigError, Descriptor, PRESETS, SlamConfig, SlamPreset};
pub use outcome::{FrameError, FrameOutcome, FramePose, Mapped, SlamFrame, TrackingState, TrajectoryPose};
pub use schedule::Schedule;
pub use self_calibration::{SelfCalibration, SelfCalibrationError, SelfCalibrator};
pub use shutter::{Exposure, Readout};
pub use system::Slam;
pub use timing::{StageTimer, StageTimes};
