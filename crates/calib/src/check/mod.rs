//! Is a calibration plausible for given images?

mod camera;
mod lines;
mod plausible;

pub use camera::{CameraCheck, Finding, Severity};
pub use plausible::check_camera;
