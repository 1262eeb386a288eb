//! Is a calibration plausible for given images?

mod camera;
mod groups;
mod lines;
mod plausible;

pub use camera::{CameraCheck, Finding, Severity};
pub use groups::{SeveralCameras, several_cameras};
pub use plausible::check_camera;
