//! The forms of Kalibr, ROS and OpenCV.

use std::collections::BTreeMap;

use serde::Deserialize;
use visloc_core::geom::{Camera, Distortion};

use crate::{ros_lens::distortion_of_ros, text::yaml_reason};

/// `camchain.yaml` of Kalibr: one entry a camera.
type Chain = BTreeMap<String, KalibrCamera>;

#[derive(Deserialize)]
struct KalibrCamera {
    camera_model: String,
    #[serde(default)]
    rostopic: String,
    #[serde(default)]
    distortion_model: String,
    #[serde(default)]
    distortion_coeffs: Vec<f64>,
    intrinsics: Vec<f64>,
    resolution: [u32; 2],
}

/// The camera of a chain of one. Entries that are no cameras cannot be there.
pub(super) fn kalibr(text: &str) -> Result<Camera, String> {
    let chain: Chain = serde_saphyr::from_str(text).map_err(|error| yaml_reason(&error))?;
    let (name, entry) = chain.iter().next().ok_or("expected cam0, found nothing")?;
    if chain.len() > 1 {
        let names: Vec<String> =
            chain.iter().map(|(name, entry)| format!("{name} {}", entry.rostopic)).collect();
        return Err(format!(
            "expected one camera, found {} ({}): keep the entry of yours in a file of its own",
            chain.len(),
            names.join(", ")
        ));
    }
    if entry.camera_model != "pinhole" {
        return Err(format!(
            "{name}: expected camera_model pinhole, found '{}'; calibrate with pinhole-radtan or pinhole-equi",
            entry.camera_model
        ));
    }
    let [fx, fy, cx, cy] = entry.intrinsics[..] else {
        return Err(format!(
            "{name}: expected intrinsics fx, fy, cx, cy, found {} numbers",
            entry.intrinsics.len()
        ));
    };
    let lens = match (entry.distortion_model.as_str(), &entry.distortion_coeffs[..]) {
        ("none" | "", _) => Distortion::None,
        ("radtan", [k1, k2, p1, p2]) => Distortion::RadialTangential([*k1, *k2, *p1, *p2, 0.0]),
        ("equidistant", [k1, k2, k3, k4]) => Distortion::KannalaBrandt([*k1, *k2, *k3, *k4]),
        (model, k) => {
            return Err(format!(
                "{name}: expected distortion_model radtan or equidistant with 4 coefficients, found '{model}' with {}",
                k.len()
            ));
        }
    };
    Camera::checked(entry.resolution.into(), (fx, fy), (cx, cy), lens).map_err(|error| error.to_string())
}

#[derive(Deserialize)]
struct Matrix {
    data: Vec<f64>,
}

/// What ROS's and OpenCV's calibrators write.
#[derive(Deserialize)]
struct MatrixFile {
    image_width: Option<u32>,
    image_height: Option<u32>,
    #[serde(alias = "Camera_Matrix", alias = "cameraMatrix", alias = "K")]
    camera_matrix: Matrix,
    #[serde(alias = "Distortion_Coefficients", alias = "distCoeffs", alias = "D")]
    distortion_coefficients: Option<Matrix>,
    #[serde(default)]
    distortion_model: String,
    /// OpenCV's example program writes it.
    #[serde(default)]
    fisheye_model: u8,
}

/// A file with `camera_matrix`; OpenCV's is not quite YAML.
pub(super) fn matrices(text: &str) -> Result<Camera, String> {
    let yaml: String = text
        .lines()
        .filter(|line| !line.starts_with('%'))
        .map(|line| line.replace("!!opencv-matrix", "") + "\n")
        .collect();
    let file: MatrixFile = serde_saphyr::from_str(&yaml).map_err(|error| yaml_reason(&error))?;
    let (Some(width), Some(height)) = (file.image_width, file.image_height) else {
        return Err("expected image_width and image_height, found none".to_owned());
    };
    let [fx, skew, cx, _, fy, cy, ..] = file.camera_matrix.data[..] else {
        return Err(format!(
            "expected the 9 numbers of camera_matrix, found {}",
            file.camera_matrix.data.len()
        ));
    };
    if skew.abs() > 1e-6 * fx {
        return Err(format!("expected a camera_matrix without skew, found {skew}"));
    }
    let d = file.distortion_coefficients.map(|m| m.data).unwrap_or_default();
    let model = if file.fisheye_model != 0 { "equidistant" } else { file.distortion_model.as_str() };
    let lens = distortion_of_ros(model, &d)?;
    Camera::checked((width, height), (fx, fy), (cx, cy), lens).map_err(|error| error.to_string())
}
