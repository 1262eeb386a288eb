//! The forms of Kalibr, ROS and OpenCV.

use std::collections::BTreeMap;

use serde::Deserialize;
use visloc_core::geom::{Camera, Distortion};

use super::{
    Calibration,
    lens_names::ros_model,
    tables::{Table, Value, plain},
};
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
        let names: Vec<String> = chain
            .iter()
            .map(|(name, entry)| format!("{name} {}", entry.rostopic).trim_end().to_owned())
            .collect();
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

/// What the calibrators of ROS and OpenCV write, and programs that use OpenCV, by whatever names: a camera matrix, the coefficients of
/// its lens, maybe a size. `None` for other files.
pub(super) fn matrices(table: &Table) -> Option<Result<Calibration, String>> {
    // Other programs write the numbers themselves, some with matrices of other things.
    if table.has_numbers() {
        return None;
    }
    let lists = table.lists();
    let (key, matrix) = match camera_matrix(&lists) {
        Ok(found) => found?,
        Err(reason) => return Some(Err(reason)),
    };
    Some(of_matrix(table, &lists, key, &rows(key, matrix)))
}

/// The rows of a matrix. Open3D writes its columns, and says so by the name.
fn rows(key: &str, matrix: &[f64]) -> Vec<f64> {
    match matrix {
        [fx, skew, 0.0, 0.0, fy, 0.0, cx, cy, 1.0] if plain(key) == "intrinsicmatrix" => {
            vec![*fx, 0.0, *cx, *skew, *fy, *cy, 0.0, 0.0, 1.0]
        }
        rows => rows.to_vec(),
    }
}

/// The camera matrix, told by its name, else by its form; `None` if there is none.
pub(super) fn camera_matrix<'a>(
    lists: &'a [(&'a str, Vec<f64>)],
) -> Result<Option<(&'a str, &'a [f64])>, String> {
    const NAMES: [&str; 4] = ["cameramatrix", "k", "mtx", "intrinsicmatrix"];
    let named = lists.iter().find(|(key, _)| NAMES.contains(&plain(key).as_str()));
    if let Some((key, numbers)) = named {
        return match numbers.len() {
            9 => Ok(Some((key, numbers))),
            found => Err(format!("expected the 9 numbers of {key}, found {found}")),
        };
    }
    // A focal length of a pixel is none: rotations have such numbers.
    let is_camera = |m: &[f64]| matches!(m, [fx, _, _, 0.0, fy, _, 0.0, 0.0, 1.0] if fx.min(*fy) > 1.0);
    let alike: Vec<&(&str, Vec<f64>)> = lists.iter().filter(|(_, numbers)| is_camera(numbers)).collect();
    match alike[..] {
        [] => Ok(None),
        [(key, numbers)] => Ok(Some((key, numbers))),
        _ => {
            let names: Vec<&str> = alike.iter().map(|(key, _)| *key).collect();
            Err(format!(
                "expected one camera, found the matrices {}: keep that of yours, with the coefficients of its lens, in a file of its own",
                names.join(", ")
            ))
        }
    }
}

fn of_matrix(
    table: &Table,
    lists: &[(&str, Vec<f64>)],
    key: &str,
    matrix: &[f64],
) -> Result<Calibration, String> {
    let [fx, skew, cx, _, fy, cy, ..] = matrix[..] else {
        return Err(format!("expected the 9 numbers of {key}, found {}", matrix.len()));
    };
    if matrix[6..] != [0.0, 0.0, 1.0] {
        return Err(format!(
            "expected a {key} whose last row is 0 0 1, found {} {} {}: is it transposed, as in MATLAB?",
            matrix[6], matrix[7], matrix[8]
        ));
    }
    if skew.abs() > 1e-6 * fx {
        return Err(format!("expected a {key} without skew, found {skew}"));
    }
    let number = |names: &[&str]| names.iter().find_map(|name| table.get(name)?.number());
    // OpenCV's example program writes the flag.
    let is_fisheye = number(&["fisheye_model"]).is_some_and(|flag| flag != 0.0);
    let k = coefficients(lists, key)?;
    let model = match ["distortion_model", "model"].iter().find_map(|key| table.get(key)) {
        _ if is_fisheye => "equidistant",
        Some(Value::Text(model)) => ros_model(model, k)?,
        _ => "",
    };
    Ok(Calibration {
        size_px: size_px(table, lists)?,
        distortion: distortion_of_ros(model, k)?,
        rate_hz: number(&["fps", "rate_hz"]).filter(|rate| *rate > 0.0),
        ..Calibration::pinhole((fx, fy), (cx, cy))
    })
}

/// Whether a list of this name has the coefficients of a lens.
pub(super) fn is_lens(key: &str) -> bool {
    let name = plain(key);
    ["dist", "coef"].iter().any(|start| name.starts_with(start))
        || name.strip_prefix('d').is_some_and(|rest| rest.parse::<u8>().is_ok() || rest.is_empty())
}

/// The coefficients of the lens whose camera matrix has a name.
fn coefficients<'a>(lists: &'a [(&'a str, Vec<f64>)], matrix: &str) -> Result<&'a [f64], String> {
    const LENGTHS: [usize; 5] = [4, 5, 8, 12, 14];
    let lenses: Vec<&(&str, Vec<f64>)> = lists.iter().filter(|(key, _)| is_lens(key)).collect();
    match lenses[..] {
        [] => {
            let unknown = lists.iter().find(|(key, numbers)| {
                let may_be_lens = LENGTHS.contains(&numbers.len()) && numbers.iter().all(|k| k.is_finite());
                *key != matrix && may_be_lens && !is_projection(key)
            });
            match unknown {
                None => Ok(&[]),
                Some((key, numbers)) => Err(format!(
                    "expected the coefficients of the lens as distortion_coefficients, found {} numbers {key}: give them that name, or leave \
                     them out if they are none",
                    numbers.len()
                )),
            }
        }
        [(_, numbers)] => Ok(numbers),
        _ => {
            let names: Vec<&str> = lenses.iter().map(|(key, _)| *key).collect();
            Err(format!("expected the coefficients of one lens, found {}", names.join(", ")))
        }
    }
}

/// Whether a list is the projection matrix or a region that ROS writes beside the camera matrix.
fn is_projection(key: &str) -> bool {
    ["projectionmatrix", "p", "roi", "imagesize", "resolution"].contains(&plain(key).as_str())
}

fn size_px(table: &Table, lists: &[(&str, Vec<f64>)]) -> Result<Option<(u32, u32)>, String> {
    let list =
        lists.iter().find(|(key, _)| ["imagesize", "resolution", "size"].contains(&plain(key).as_str()));
    let side = |names: &[&str]| names.iter().find_map(|name| table.get(name)?.number());
    let sides = side(&["image_width", "width", "w"]).zip(side(&["image_height", "height", "h"]));
    let is_size = |v: &f64| (1.0..=100_000.0).contains(v) && v.fract() == 0.0;
    match (list.map(|(_, numbers)| &numbers[..]), sides) {
        (None, None) => Ok(None),
        (Some([width, height]), _) if is_size(width) && is_size(height) => {
            Ok(Some((*width as u32, *height as u32)))
        }
        (None, Some((width, height))) if is_size(&width) && is_size(&height) => {
            Ok(Some((width as u32, height as u32)))
        }
        (list, sides) => {
            let found = list.map_or_else(|| format!("{sides:?}"), |list| format!("{list:?}"));
            Err(format!("expected width and height in whole pixels, found {found}"))
        }
    }
}
