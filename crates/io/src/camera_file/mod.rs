//! Files with the calibration of one camera: our own TOML, ROS (`camera_info.yaml`), Kalibr (`camchain.yaml`) and OpenCV
//! (`FileStorage`, `%YAML:1.0`); COLMAP's `cameras.txt` and `transforms.json` are read only.
//!
//! Our own file:
//!
//! ```toml
//! model = "radial-tangential"            # or "kannala-brandt", "pinhole"
//! size_px = [640, 480]
//! focal_px = [521.3, 523.1]
//! center_px = [323.8, 236.4]
//! distortion = [-0.25, 0.09, 0.0008, -0.0006, -0.01]
//! ```
//!
//! The tables `[quality]`, how good the calibration is, and `[pose]`, where the camera stood, are for people and are not read.

mod calibration;
mod lens_names;
mod models;
mod read;
mod tables;
mod toml_form;
mod write;
mod yaml_forms;

pub use calibration::{Calibration, read_calibration};
pub use read::read_camera;
pub use toml_form::CameraToml;
pub use write::{CameraFormat, write_camera};
