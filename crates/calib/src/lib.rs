//! Calibration of one camera from pictures of a flat board.
//!
//! Data flow: images -> [`detect()`] finds the corners of a [`Board`] -> [`calibrate()`] estimates the camera, the pose of every
//! picture and the quality of both -> [`coverage()`] says what to photograph next. [`check_camera()`] asks whether a
//! calibration fits given images. [`render`] draws boards with known truth, for tests and for trying things out.
//!
//! No files, no clocks, no randomness except through a generator that is passed in.

mod board;
mod calibrate;
mod check;
mod coverage;
mod detect;
pub mod render;
mod saddles;
mod solve;
mod tags;

pub use board::{AprilGrid, Board, BoardError, BoardFrame, Checkerboard};
pub use calibrate::{
    CalibrateError, Calibration, DropReason, DroppedView, Parameter, SeenCorner, View, ViewInput, calibrate,
};
pub use check::{CameraCheck, Finding, SeveralCameras, Severity, check_camera, several_cameras};
pub use coverage::{Advice, Coverage, coverage};
pub use detect::{BoardCorner, DetectReject, Detection, detect};
pub use solve::{CameraFromBoard, LensModel};
