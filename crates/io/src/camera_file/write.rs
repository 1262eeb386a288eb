//! Writing.

use std::fmt::Write as _;

use visloc_core::geom::{Camera, Distortion};

use super::CameraToml;
use crate::ros_lens::ros_distortion;

/// Forms that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraFormat {
    /// Our own.
    Toml,
    /// `sensor_msgs/msg/CameraInfo` as `camera_info_manager` of ROS reads it.
    Ros,
    /// A chain of one camera.
    Kalibr,
    /// `FileStorage`.
    OpenCv,
}

/// The text of a file. `head` becomes a comment.
///
/// # Errors
/// If the form has no place for the lens.
pub fn write_camera(camera: &Camera, format: CameraFormat, head: &str) -> Result<String, String> {
    let comment: String = head.lines().map(|line| format!("# {line}\n")).collect();
    let body = match format {
        CameraFormat::Toml => {
            toml::to_string(&CameraToml::from(camera)).map_err(|error| error.to_string())?
        }
        CameraFormat::Ros => ros(camera),
        CameraFormat::Kalibr => kalibr(camera)?,
        // A comment before the first line would not be read.
        CameraFormat::OpenCv => return Ok(opencv(camera)),
    };
    Ok(comment + &body)
}

fn joined(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(", ")
}

fn camera_matrix(camera: &Camera) -> [f64; 9] {
    let ((fx, fy), (cx, cy)) = (camera.focal_px(), camera.center_px());
    [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
}

fn ros(camera: &Camera) -> String {
    let ((width, height), (fx, fy), (cx, cy)) = (camera.size_px(), camera.focal_px(), camera.center_px());
    let (model, d) = ros_distortion(camera.distortion());
    let mut text = format!("image_width: {width}\nimage_height: {height}\ncamera_name: camera\n");
    let matrix = |text: &mut String, name: &str, rows: usize, data: &[f64]| {
        let columns = data.len() / rows;
        let _ = writeln!(text, "{name}:\n  rows: {rows}\n  cols: {columns}\n  data: [{}]", joined(data));
    };
    matrix(&mut text, "camera_matrix", 3, &camera_matrix(camera));
    let _ = writeln!(text, "distortion_model: {model}");
    matrix(&mut text, "distortion_coefficients", 1, &d);
    matrix(&mut text, "rectification_matrix", 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    matrix(&mut text, "projection_matrix", 3, &[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]);
    text
}

fn kalibr(camera: &Camera) -> Result<String, String> {
    let (model, k) = match camera.distortion() {
        Distortion::RadialTangential([_, _, _, _, k3]) if k3 != 0.0 => {
            return Err(format!(
                "Kalibr's radtan has no k3, found {k3}; calibrate with --model radtan4, or write another form"
            ));
        }
        Distortion::RadialTangential(k) => ("radtan", k[..4].to_vec()),
        Distortion::KannalaBrandt(k) => ("equidistant", k.to_vec()),
        _ => ("none", Vec::new()),
    };
    let ((width, height), (fx, fy), (cx, cy)) = (camera.size_px(), camera.focal_px(), camera.center_px());
    Ok(format!(
        "cam0:\n  camera_model: pinhole\n  intrinsics: [{}]\n  distortion_model: {model}\n  distortion_coeffs: [{}]\n  \
         resolution: [{width}, {height}]\n",
        joined(&[fx, fy, cx, cy]),
        joined(&k)
    ))
}

fn opencv(camera: &Camera) -> String {
    let (width, height) = camera.size_px();
    let k = camera_matrix(camera);
    let (model, d) = ros_distortion(camera.distortion());
    let is_fisheye = u8::from(model == "equidistant");
    format!(
        "%YAML:1.0\n---\nimage_width: {width}\nimage_height: {height}\nfisheye_model: {is_fisheye}\ncamera_matrix: \
         !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [{}]\ndistortion_coefficients: !!opencv-matrix\n   rows: {}\n   \
         cols: 1\n   dt: d\n   data: [{}]\n",
        joined(&k),
        d.len(),
        joined(&d)
    )
}
