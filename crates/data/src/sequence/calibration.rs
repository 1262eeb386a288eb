//! A camera's calibration in `camera.yaml`: `width`, `height`, `fx`, `fy`, `cx`, `cy` and `distortion: [k1, k2, p1, p2]`, one
//! to a line.

use std::{collections::BTreeMap, fs, path::Path};

use visloc_geom::{Camera, Distortion};

use super::SequenceError;

/// Reads a calibration.
///
/// # Errors
/// If the file cannot be read, a value is missing or not a number, or no camera has these values.
pub fn read_camera_yaml(path: &Path) -> Result<Camera, SequenceError> {
    let text =
        fs::read_to_string(path).map_err(|source| SequenceError::Io { path: path.to_path_buf(), source })?;
    let mut values: BTreeMap<&str, (usize, &str)> = BTreeMap::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        if let Some((key, value)) = line.split_once(':') {
            values.insert(key.trim(), (i + 1, value.trim()));
        }
    }
    let line_error = |line, reason| SequenceError::Line { path: path.to_path_buf(), line, reason };
    let number = |key: &'static str| -> Result<f64, SequenceError> {
        let (line, value) = values.get(key).copied().ok_or_else(|| SequenceError::Layout {
            path: path.to_path_buf(),
            reason: format!("expected a line '{key}: NUMBER', found none"),
        })?;
        value.parse().map_err(|_| line_error(line, format!("expected a number for {key}, found '{value}'")))
    };
    let mut coefficients = [0.0; 5];
    if let Some((line, list)) = values.get("distortion").copied() {
        let list = list.trim_start_matches('[').trim_end_matches(']');
        for (i, value) in list.split(',').map(str::trim).filter(|v| !v.is_empty()).enumerate() {
            let slot = coefficients
                .get_mut(i)
                .ok_or_else(|| line_error(line, "expected at most 5 distortion coefficients".to_owned()))?;
            *slot =
                value.parse().map_err(|_| line_error(line, format!("expected numbers, found '{value}'")))?;
        }
    }
    let size = (number("width")? as u32, number("height")? as u32);
    let focal = (number("fx")?, number("fy")?);
    let center = (number("cx")?, number("cy")?);
    Camera::new(size, focal, center, Distortion::RadialTangential(coefficients))
        .map_err(|source| SequenceError::Camera { path: path.to_path_buf(), source })
}
