//! The cameras of models: COLMAP's `cameras.txt`, and `transforms.json` of nerfstudio and instant-ngp. Their pixels begin at their
//! corners: the center of the top-left pixel is (0.5, 0.5).

use serde::Deserialize;
use visloc_core::geom::Distortion;

use super::Calibration;
use crate::text::{data_lines, parse_number, yaml_reason};

/// Models of COLMAP that are read.
const MODELS: [&str; 7] =
    ["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV", "OPENCV_FISHEYE"];

/// The first camera, if the text is that of a model, or of a file that has to be written otherwise.
pub(super) fn in_form_of_model(text: &str) -> Option<Result<Calibration, String>> {
    let text = text.trim_start();
    if text.starts_with('<') {
        let reason = "expected YAML, found XML; OpenCV writes YAML if the name of its file ends with .yml";
        return Some(Err(reason.to_owned()));
    }
    if text.starts_with('{') {
        return Some(transforms(text));
    }
    let words: Vec<&str> = data_lines(text).next()?.1.split_whitespace().collect();
    match words[..] {
        [number, model, width, height, ref values @ ..] if is_upper(model) => {
            number.parse::<u32>().ok()?;
            Some(colmap(model, (width, height), values))
        }
        _ => None,
    }
}

fn is_upper(word: &str) -> bool {
    word.len() > 1 && word.chars().all(|c| c.is_ascii_uppercase() || c == '_')
}

/// Source: COLMAP documentation, "Camera Models".
fn colmap(model: &str, (width, height): (&str, &str), values: &[&str]) -> Result<Calibration, String> {
    let side = |text: &str| text.parse().map_err(|_| format!("expected a size in pixels, found '{text}'"));
    let size_px = Some((side(width)?, side(height)?));
    let values: Vec<f64> = values.iter().map(|value| parse_number(value)).collect::<Result<_, _>>()?;
    let radial = |k1, k2, p1, p2, k3| Distortion::RadialTangential([k1, k2, p1, p2, k3]);
    let (focal_px, (cx, cy), distortion) = match (model, &values[..]) {
        ("SIMPLE_PINHOLE", [f, cx, cy]) => ((*f, *f), (*cx, *cy), Distortion::None),
        ("PINHOLE", [fx, fy, cx, cy]) => ((*fx, *fy), (*cx, *cy), Distortion::None),
        ("SIMPLE_RADIAL", [f, cx, cy, k1]) => ((*f, *f), (*cx, *cy), radial(*k1, 0.0, 0.0, 0.0, 0.0)),
        ("RADIAL", [f, cx, cy, k1, k2]) => ((*f, *f), (*cx, *cy), radial(*k1, *k2, 0.0, 0.0, 0.0)),
        ("OPENCV", [fx, fy, cx, cy, k1, k2, p1, p2]) => {
            ((*fx, *fy), (*cx, *cy), radial(*k1, *k2, *p1, *p2, 0.0))
        }
        ("FULL_OPENCV", [fx, fy, cx, cy, k1, k2, p1, p2, k3, rest @ ..])
            if rest.iter().all(|k| *k == 0.0) =>
        {
            ((*fx, *fy), (*cx, *cy), radial(*k1, *k2, *p1, *p2, *k3))
        }
        ("OPENCV_FISHEYE", [fx, fy, cx, cy, k1, k2, k3, k4]) => {
            ((*fx, *fy), (*cx, *cy), Distortion::KannalaBrandt([*k1, *k2, *k3, *k4]))
        }
        _ => {
            return Err(format!(
                "expected a camera of COLMAP, one of {}, found '{model}' with {} values",
                MODELS.join(", "),
                values.len()
            ));
        }
    };
    Ok(Calibration { size_px, distortion, ..Calibration::pinhole(focal_px, (cx - 0.5, cy - 0.5)) })
}

/// A camera of `transforms.json`: of all pictures, or of the first one.
#[derive(Deserialize)]
struct Transforms {
    #[serde(flatten)]
    camera: Option<TransformsCamera>,
    #[serde(default)]
    frames: Vec<TransformsFrame>,
}

#[derive(Deserialize)]
struct TransformsFrame {
    #[serde(flatten)]
    camera: Option<TransformsCamera>,
}

#[derive(Deserialize)]
struct TransformsCamera {
    #[serde(default)]
    camera_model: String,
    w: f64,
    h: f64,
    fl_x: f64,
    fl_y: Option<f64>,
    cx: f64,
    cy: f64,
    #[serde(default)]
    k1: f64,
    #[serde(default)]
    k2: f64,
    #[serde(default)]
    k3: f64,
    #[serde(default)]
    k4: f64,
    #[serde(default)]
    p1: f64,
    #[serde(default)]
    p2: f64,
}

fn transforms(text: &str) -> Result<Calibration, String> {
    let read: Transforms = serde_saphyr::from_str(text).map_err(|error| yaml_reason(&error))?;
    let of_frame = read.frames.into_iter().find_map(|frame| frame.camera);
    let Some(camera) = read.camera.or(of_frame) else {
        return Err("expected w, h, fl_x, cx and cy of a transforms.json, found none".to_owned());
    };
    let TransformsCamera { w, h, fl_x, fl_y, cx, cy, k1, k2, k3, k4, p1, p2, .. } = camera;
    let distortion = match camera.camera_model.as_str() {
        "OPENCV_FISHEYE" => Distortion::KannalaBrandt([k1, k2, k3, k4]),
        "PINHOLE" => Distortion::None,
        "" | "OPENCV" if k4 == 0.0 => Distortion::RadialTangential([k1, k2, p1, p2, k3]),
        model => {
            return Err(format!(
                "expected camera_model OPENCV or OPENCV_FISHEYE, found '{model}' and k4 = {k4}"
            ));
        }
    };
    let is_size = |side: f64| side.fract() == 0.0 && (1.0..=100_000.0).contains(&side);
    if !is_size(w) || !is_size(h) {
        return Err(format!("expected w and h in whole pixels, found {w} and {h}"));
    }
    let size_px = Some((w as u32, h as u32));
    let center_px = (cx - 0.5, cy - 0.5);
    Ok(Calibration { size_px, distortion, ..Calibration::pinhole((fl_x, fl_y.unwrap_or(fl_x)), center_px) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Calibration, String> {
        in_form_of_model(text).unwrap()
    }

    #[test]
    fn the_same_camera_of_both() {
        let colmap =
            "# Camera list\n1 OPENCV 640 480 500 501 320 240 0.1 -0.2 0.001 0.002\n2 PINHOLE 1 1 1 1 1 1\n";
        let values = r#""camera_model": "OPENCV", "w": 640, "h": 480, "fl_x": 500, "fl_y": 501, "cx": 320, "cy": 240,
                        "k1": 0.1, "k2": -0.2, "p1": 0.001, "p2": 0.002"#;
        let expected = Calibration {
            size_px: Some((640, 480)),
            distortion: Distortion::RadialTangential([0.1, -0.2, 0.001, 0.002, 0.0]),
            ..Calibration::pinhole((500.0, 501.0), (319.5, 239.5))
        };
        let of_frame = format!("{{\"frames\": [{{\"file_path\": \"a.png\", {values}}}]}}");
        for text in [colmap, &format!("{{{values}, \"frames\": []}}"), &of_frame] {
            assert_eq!(read(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        for (text, expected) in [
            ("1 FOV 640 480 500 501 320 240 1", "one of SIMPLE_PINHOLE, PINHOLE"),
            ("1 PINHOLE 640 480 500", "'PINHOLE' with 1 values"),
            ("{\"frames\": []}", "expected w, h, fl_x"),
            ("<?xml version=\"1.0\"?>", "found XML"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        assert!(in_form_of_model("fx: 500\n").is_none() && in_form_of_model("").is_none());
        assert!(in_form_of_model("707 0 601 0 0 708 183 0 0 0 1 0").is_none());
    }
}
