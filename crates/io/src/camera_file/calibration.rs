//! Calibrations in the files that datasets and calibrators write. Which form a file has is told from its content:
//!
//! * `key: value` (YAML): `width`, `height`, `fx`, `fy`, `cx`, `cy`, `distortion: [k1, k2, p1, p2, k3]`, `fps`; the same with the
//!   names of EuRoC (`resolution`, `intrinsics`, `distortion_coefficients`, `rate_hz`, `T_BS`) and of ORB-SLAM (`Camera.fx`,
//!   `Camera.k1`, ...);
//! * our TOML, `camchain.yaml` of Kalibr, and the camera matrix that ROS, OpenCV and programs with it write (YAML or JSON), by whatever name;
//! * COLMAP's `cameras.txt` and the `transforms.json` of nerfstudio, the first camera;
//! * KITTI: twelve numbers of a projection matrix, maybe after `P0:`;
//! * Middlebury: a count and lines `IMAGE K R t`.
//!
//! Tables may be YAML, JSON or TOML, and the camera may stand in a table of its own: what RealSense and Open3D write is read as well.

use std::{collections::BTreeMap, path::Path};

use nalgebra::{Matrix3, Rotation3, Vector3};
use visloc_core::{
    files,
    geom::{Camera, CameraFrame, Distortion, Rigid3},
};

use super::{
    lens_names::ros_model,
    models::in_form_of_model,
    read::{in_known_form, is_toml},
    tables::{Table, Value},
    yaml_forms::{is_lens, matrices},
};
use crate::{
    FileError,
    text::{data_lines, parse_number},
};

/// For people who have another one.
const KNOWN_FORMS: &str = "the TOML of visloc, YAML of ROS, OpenCV, Kalibr, EuRoC and ORB-SLAM, COLMAP's cameras.txt, transforms.json and \
                           KITTI's calib.txt (docs/datasets.md)";

/// What a calibration says.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Width and height of the images, pixels.
    pub size_px: Option<(u32, u32)>,
    /// fx and fy, pixels.
    pub focal_px: (f64, f64),
    /// cx and cy, pixels; the center of the top-left pixel is (0, 0).
    pub center_px: (f64, f64),
    /// The lens.
    pub distortion: Distortion,
    /// Images a second.
    pub rate_hz: Option<f64>,
    /// Where the camera is in the body whose poses the truth gives (the body's frame has no type of its own).
    pub body_from_camera: Option<Rigid3<CameraFrame, CameraFrame>>,
}

impl Calibration {
    /// A camera of unknown size without distortion.
    pub fn pinhole(focal_px: (f64, f64), center_px: (f64, f64)) -> Self {
        Self {
            size_px: None,
            focal_px,
            center_px,
            distortion: Distortion::None,
            rate_hz: None,
            body_from_camera: None,
        }
    }

    /// What is known of a camera.
    pub fn of(camera: &Camera) -> Self {
        let size_px = Some(camera.size_px());
        let distortion = camera.distortion();
        Self { size_px, distortion, ..Self::pinhole(camera.focal_px(), camera.center_px()) }
    }

    /// The camera for images of a size.
    ///
    /// # Errors
    /// If no camera has these values.
    pub fn camera(&self, size_px: (u32, u32), path: &Path) -> Result<Camera, FileError> {
        Camera::checked(size_px, self.focal_px, self.center_px, self.distortion)
            .map_err(|source| FileError::Camera { path: path.to_path_buf(), source })
    }
}

/// Reads a calibration.
///
/// # Errors
/// If the file cannot be read, a value is missing or not a number, or the lens model is not known.
pub fn read_calibration(path: &Path) -> Result<Calibration, FileError> {
    let text = files::read_text(path).map_err(FileError::io(path))?;
    let form = |reason| FileError::form(path, reason);
    let of_toml = if is_toml(path) { Table::of_foreign_toml(&text) } else { None };
    let table = of_toml.map_or_else(|| Table::read(&text), Ok);
    if let Some(camera) = in_known_form(path, &text) {
        let camera = camera.map_err(form)?;
        let table = table.and_then(Table::of_camera).ok().flatten().unwrap_or_default();
        return Ok(Calibration {
            rate_hz: Keys::of(&table, &text, path).rate_hz()?,
            ..Calibration::of(&camera)
        });
    }
    let is_of_model = |table: &Table| table.get("frames").or(table.get("fl_x")).is_some();
    if let Ok(table) = &table
        && !is_of_model(table)
    {
        let camera = table.clone().of_camera().map_err(form)?;
        // What is wrong with a matrix is said for files without a camera, too.
        if let Some(calibration) = matrices(camera.as_ref().unwrap_or(table)) {
            return calibration.map_err(form);
        }
        if let Some(camera) = camera {
            return Keys::of(&camera, &text, path).calibration();
        }
    }
    if let Some(calibration) = in_form_of_model(&text) {
        return calibration.map_err(form);
    }
    let second = data_lines(&text).nth(1).map_or(0, |(_, line)| line.split_whitespace().count());
    let first = data_lines(&text).next().unwrap_or_default();
    let matrix = first.1.split_once(':').map_or(first.1, |(_, values)| values);
    if matrix.split_whitespace().count() == 12 {
        return kitti(matrix).map_err(FileError::line(path, first.0));
    }
    if second == 22 {
        let (number, line) = data_lines(&text).nth(1).unwrap_or_default();
        return middlebury(line).map_err(FileError::line(path, number));
    }
    let table = table.map_err(|reason| form(format!("{reason}; known are {KNOWN_FORMS}")))?;
    Keys::of(&table, &text, path).calibration()
}

/// A projection matrix: fx 0 cx . 0 fy cy . 0 0 1 .
fn kitti(matrix: &str) -> Result<Calibration, String> {
    let p: Vec<f64> = matrix.split_whitespace().map(parse_number).collect::<Result<_, _>>()?;
    Ok(Calibration::pinhole((p[0], p[5]), (p[2], p[6])))
}

/// A name, K, R and t.
fn middlebury(line: &str) -> Result<Calibration, String> {
    let k: Vec<f64> = line.split_whitespace().skip(1).map(parse_number).collect::<Result<_, _>>()?;
    Ok(Calibration::pinhole((k[0], k[4]), (k[2], k[5])))
}

/// The values of a camera by their keys, with the line where they stand.
struct Keys<'a> {
    path: &'a Path,
    values: BTreeMap<String, (usize, String)>,
}

/// Focal lengths and principal point, horizontal and vertical, pixels.
type Intrinsics = ((f64, f64), (f64, f64));

impl<'a> Keys<'a> {
    /// Those of a table of the text.
    fn of(table: &Table, text: &str, path: &'a Path) -> Self {
        let begins = |line: &str, key: &str| line.trim_start().trim_start_matches('"').starts_with(key);
        let line = |key: &str| {
            let quoted = format!("\"{key}\"");
            text.lines().position(|line| begins(line, key) || line.contains(&quoted)).map_or(1, |at| at + 1)
        };
        let value = |value: &Value| match value {
            Value::Number(number) => Some(number.to_string()),
            Value::Text(text) => Some(text.clone()),
            value => value.numbers().map(|list| format!("{list:?}")),
        };
        let values = table.iter().filter_map(|(key, v)| Some((key.to_owned(), (line(key), value(v)?))));
        Self { path, values: values.collect() }
    }

    /// The first of these keys that has a value of its own.
    fn find(&self, names: &[&str]) -> Option<&(usize, String)> {
        names.iter().filter_map(|name| self.values.get(*name)).find(|(_, value)| !value.is_empty())
    }

    fn optional(&self, names: &[&str]) -> Result<Option<f64>, FileError> {
        let Some((line, value)) = self.find(names) else { return Ok(None) };
        let wrong = |_| format!("expected a number for {}, found '{value}'", names[0]);
        let number = parse_number(value.trim_matches(['"', '\''])).map_err(wrong);
        number.map(Some).map_err(FileError::line(self.path, *line))
    }

    fn number(&self, names: &[&str]) -> Result<f64, FileError> {
        self.optional(names)?.ok_or_else(|| {
            let sign = if is_toml(self.path) { " =" } else { ":" };
            let reason =
                format!("expected a line '{}{sign} NUMBER', found none; known are {KNOWN_FORMS}", names[0]);
            FileError::form(self.path, reason)
        })
    }

    fn list(&self, names: &[&str]) -> Result<Option<(usize, Vec<f64>)>, FileError> {
        let Some((line, value)) = self.find(names) else { return Ok(None) };
        // The rows of a matrix one after the other.
        let inside = value.replace(['[', ']'], " ");
        let numbers = inside.split(',').map(str::trim).filter(|v| !v.is_empty()).map(parse_number);
        let numbers: Result<Vec<f64>, String> = numbers.collect();
        numbers.map(|list| Some((*line, list))).map_err(FileError::line(self.path, *line))
    }

    fn calibration(&self) -> Result<Calibration, FileError> {
        let (focal_px, center_px) = self.intrinsics()?;
        Ok(Calibration {
            size_px: self.size()?,
            focal_px,
            center_px,
            distortion: self.distortion()?,
            rate_hz: self.rate_hz()?,
            body_from_camera: self.body_from_camera()?,
        })
    }

    /// Images a second.
    fn rate_hz(&self) -> Result<Option<f64>, FileError> {
        Ok(self.optional(&["fps", "rate_hz", "Camera.fps"])?.filter(|rate| *rate > 0.0))
    }

    /// Focal lengths and principal point.
    fn intrinsics(&self) -> Result<Intrinsics, FileError> {
        if let Some((line, values)) = self.list(&["intrinsics"])? {
            let [fx, fy, cx, cy] = values[..] else {
                let reason = format!("expected fx, fy, cx, cy, found {} numbers", values.len());
                return Err(FileError::line(self.path, line)(reason));
            };
            return Ok(((fx, fy), (cx, cy)));
        }
        if let (Some((_, f)), Some((line, c))) = (self.list(&["focal_px"])?, self.list(&["center_px"])?) {
            let ([fx, fy], [cx, cy]) = (&f[..], &c[..]) else {
                let reason = format!("expected pairs focal_px and center_px, found {f:?} and {c:?}");
                return Err(FileError::line(self.path, line)(reason));
            };
            return Ok(((*fx, *fy), (*cx, *cy)));
        }
        let focal = (self.number(&["fx", "Camera.fx", "Camera1.fx"])?, self.fy()?);
        let center_x = self.number(&["cx", "ppx", "Camera.cx", "Camera1.cx"])?;
        Ok((focal, (center_x, self.number(&["cy", "ppy", "Camera.cy", "Camera1.cy"])?)))
    }

    fn fy(&self) -> Result<f64, FileError> {
        self.number(&["fy", "Camera.fy", "Camera1.fy"])
    }

    fn size(&self) -> Result<Option<(u32, u32)>, FileError> {
        let (line, values) = match self.list(&["resolution", "image_size", "size_px"])? {
            Some((line, values)) => (line, values),
            None => {
                let width = self.optional(&["width", "image_width", "Camera.width"])?;
                let height = self.optional(&["height", "image_height", "Camera.height"])?;
                let Some((width, height)) = width.zip(height) else { return Ok(None) };
                let line = self.find(&["width", "image_width", "Camera.width"]).map_or(1, |found| found.0);
                (line, vec![width, height])
            }
        };
        let is_size = |v: &f64| (1.0..=100_000.0).contains(v) && v.fract() == 0.0;
        match values[..] {
            [width, height] if is_size(&width) && is_size(&height) => Ok(Some((width as u32, height as u32))),
            _ => {
                let reason = format!("expected width and height in whole pixels, found {values:?}");
                Err(FileError::line(self.path, line)(reason))
            }
        }
    }

    fn distortion(&self) -> Result<Distortion, FileError> {
        let (model_line, model) =
            self.find(&["distortion_model", "model", "Camera.type"]).cloned().unwrap_or_default();
        let (line, k) = match self.list(&self.lenses()?)? {
            Some(list) => list,
            None => (model_line, self.separate_coefficients(&model)?),
        };
        let known = ros_model(&model, &k).map_err(FileError::line(self.path, model_line))?;
        let (is_fisheye, expected) = match known {
            "equidistant" => (true, "4"),
            _ => (false, "at most 5"),
        };
        match k[..] {
            [k1, k2, k3, k4] if is_fisheye => Ok(Distortion::KannalaBrandt([k1, k2, k3, k4])),
            _ if is_fisheye || k.len() > 5 => {
                let reason = format!("expected {expected} distortion coefficients, found {}", k.len());
                Err(FileError::line(self.path, line)(reason))
            }
            [_, _, third] if third != 0.0 => {
                let reason = "expected 4 or 5 distortion coefficients (k1, k2, p1, p2, k3), found 3, whose third may be p1 or k3: write all \
                              five";
                Err(FileError::line(self.path, line)(reason.to_owned()))
            }
            _ => {
                let mut padded = [0.0; 5];
                padded[..k.len()].copy_from_slice(&k);
                Ok(Distortion::RadialTangential(padded))
            }
        }
    }

    /// The names of the lists that have the coefficients of a lens: one at most.
    fn lenses(&self) -> Result<Vec<&str>, FileError> {
        let is_list =
            |(key, (_, value)): &(&String, &(usize, String))| is_lens(key) && value.starts_with('[');
        let lenses: Vec<&str> = self.values.iter().filter(is_list).map(|(key, _)| key.as_str()).collect();
        if lenses.len() > 1 {
            let reason = format!("expected the coefficients of one lens, found {}", lenses.join(", "));
            return Err(FileError::form(self.path, reason));
        }
        Ok(lenses)
    }

    /// Coefficients under names of their own; those that are not there are zero.
    fn separate_coefficients(&self, model: &str) -> Result<Vec<f64>, FileError> {
        let is_fisheye = ros_model(model, &[]) == Ok("equidistant");
        let names: &[&str] = if is_fisheye {
            &["k1", "k2", "k3", "k4"]
        } else {
            &["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]
        };
        let number = |name: &&str| {
            let names = [(*name).to_owned(), format!("Camera.{name}"), format!("Camera1.{name}")];
            Ok(self.optional(&names.each_ref().map(String::as_str))?.unwrap_or_default())
        };
        let mut k: Vec<f64> = names.iter().map(number).collect::<Result<_, _>>()?;
        if !is_fisheye && k[5..].iter().all(|k| *k == 0.0) {
            k.truncate(5);
        }
        Ok(k)
    }

    fn body_from_camera(&self) -> Result<Option<Rigid3<CameraFrame, CameraFrame>>, FileError> {
        let Some((line, t)) = self.list(&["T_BS"])? else { return Ok(None) };
        if t.len() != 16 {
            let reason = format!("expected the 16 numbers of T_BS, found {}", t.len());
            return Err(FileError::line(self.path, line)(reason));
        }
        let rotation = Matrix3::new(t[0], t[1], t[2], t[4], t[5], t[6], t[8], t[9], t[10]);
        if (rotation.transpose() * rotation - Matrix3::identity()).norm() > 1e-3 {
            let reason = "expected a rotation in T_BS, found another matrix".to_owned();
            return Err(FileError::line(self.path, line)(reason));
        }
        let translation = Vector3::new(t[3], t[7], t[11]);
        Ok(Some(Rigid3::new(Rotation3::from_matrix_unchecked(rotation), translation)))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn read(text: &str) -> Result<Calibration, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.yaml");
        fs::write(&path, text).unwrap();
        read_calibration(&path).map_err(|error| error.to_string())
    }

    const OURS: &str = "width: 640\nheight: 480\nfx: 500\nfy: 501\ncx: 319.5\ncy: 239.5 # middle\n\
                        distortion: [0.1, -0.2, 0.001, 0.002]\nfps: 20\n";

    #[test]
    fn the_same_camera_in_every_form() {
        let euroc = "%YAML:1.0\nT_BS:\n  cols: 4\n  data: [1, 0, 0, 0.5,\n    0, 1, 0, 0,\n    0, 0, 1, 0, 0, 0, 0, 1]\n\
                     rate_hz: 20\nresolution: [640, 480]\nintrinsics: [500, 501, 319.5, 239.5] #fu\n\
                     distortion_model: radial-tangential\ndistortion_coefficients: [0.1, -0.2, 0.001, 0.002]\n";
        let opencv = "%YAML:1.0\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   \
                      data: [ 500., 0., 319.5, 0.,\n       501., 239.5, 0., 0., 1. ]\ndistortion_coefficients: \
                      !!opencv-matrix\n   data: [ 0.1, -0.2, 0.001, 0.002, 0. ]\nfps: 20\n";
        let orb = "%YAML:1.0\nCamera.fx: 500\nCamera.fy: 501\nCamera.cx: 319.5\nCamera.cy: 239.5\nCamera.k1: 0.1\n\
                   Camera.k2: -0.2\nCamera.p1: 0.001\nCamera.p2: 0.002\nCamera.width: 640\nCamera.height: 480\n\
                   Camera.fps: 20.0\n";
        let ours = read(OURS).unwrap();
        assert_eq!(ours.size_px, Some((640, 480)));
        assert_eq!(ours.distortion, Distortion::RadialTangential([0.1, -0.2, 0.001, 0.002, 0.0]));
        assert_eq!(ours.rate_hz, Some(20.0));
        let kalibr = "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]\n  distortion_model: \
                      radtan\n  intrinsics: [500, 501, 319.5, 239.5]\n  resolution: [640, 480]\n";
        assert_eq!(Calibration { rate_hz: Some(20.0), ..read(kalibr).unwrap() }, ours);
        for text in [euroc, opencv, orb] {
            let other = read(text).unwrap();
            assert_eq!(Calibration { body_from_camera: None, ..other.clone() }, ours, "{text}");
        }
        assert_eq!(read(euroc).unwrap().body_from_camera.unwrap().translation().x, 0.5);
    }

    #[test]
    fn matrices_of_kitti_and_middlebury() {
        for prefix in ["P0: ", ""] {
            let text =
                format!("{prefix}707 0 601 0 0 708 183 0 0 0 1 0\nP1: 707 0 601 -379 0 708 183 0 0 0 1 0\n");
            assert_eq!(read(&text).unwrap(), Calibration::pinhole((707.0, 708.0), (601.0, 183.0)));
        }
        let text = "2\na.png 1520 0 302 0 1525 246 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n";
        assert_eq!(read(text).unwrap(), Calibration::pinhole((1520.0, 1525.0), (302.0, 246.0)));
    }

    #[test]
    fn rows_of_a_matrix() {
        let rows = "camera_matrix: [[500, 0, 319.5],\n  [0, 501, 239.5], [0, 0, 1]]\ndist_coeffs: [[0.1, -0.2, 0.001, 0.002, 0]]\n";
        let Calibration { focal_px, center_px, distortion, .. } = read(OURS).unwrap();
        let of_rows = read(rows).unwrap();
        assert_eq!(of_rows, Calibration { distortion, ..Calibration::pinhole(focal_px, center_px) });
        assert_eq!(
            read(&format!("image_width: 640\nimage_height: 480\n{rows}")).unwrap().size_px,
            Some((640, 480))
        );
    }

    #[test]
    fn a_camera_matrix_by_whatever_name() {
        let matrix = "[500, 0, 319.5, 0, 501, 239.5, 0, 0, 1]";
        let rows = "[[500, 0, 319.5], [0, 501, 239.5], [0, 0, 1]]";
        let opencv = format!("!!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: {matrix}");
        let k = "[0.1, -0.2, 0.001, 0.002, 0]";
        let ours = Calibration { size_px: None, rate_hz: None, ..read(OURS).unwrap() };
        for text in [
            format!(
                "%YAML:1.0\n---\nM1: {opencv}\nD1: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: {k}\n"
            ),
            format!("K: {opencv}\nD: {k}\n"),
            format!("cameraMatrix: {rows}\ndistCoeffs: [{k}]\nrvec: [0.1, 0.2, 0.3]\n"),
            format!("{{\"mtx\": {rows}, \"dist\": [{k}]}}"),
            format!(
                "camera_matrix: {{rows: 3, cols: 3, data: {matrix}}}\ndist_coeffs: {{data: {k}}}\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
            ),
        ] {
            assert_eq!(read(&text).unwrap(), ours, "{text}");
        }
        let sized = format!("image_width: 640\nimage_height: 480\ncamera_matrix: {rows}\ndist_coeffs: {k}\n");
        assert_eq!(read(&sized).unwrap(), Calibration { size_px: Some((640, 480)), ..ours });
        for (text, expected) in [
            (format!("M1: {rows}\nM2: {rows}\n"), "expected one camera, found the matrices M1, M2"),
            (format!("K: {rows}\nlens: {k}\n"), "found 5 numbers lens"),
            (format!("K: {rows}\nD1: {k}\nD2: {k}\n"), "coefficients of one lens, found D1, D2"),
            ("K: [500, 0, 319.5]\n".to_owned(), "expected the 9 numbers of K, found 3"),
        ] {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error} ({expected})");
        }
    }

    #[test]
    fn the_same_camera_as_json_and_in_tables_of_its_own() {
        let k = "[0.1, -0.2, 0.001, 0.002, 0]";
        let size = "\"width\": 640, \"height\": 480";
        let focal = "\"fx\": 500, \"fy\": 501";
        let columns = "[500, 0, 0, 0, 501, 0, 319.5, 239.5, 1]";
        let rows = "[[500, 0, 319.5], [0, 501, 239.5], [0, 0, 1]]";
        let ours = Calibration { rate_hz: None, ..read(OURS).unwrap() };
        for text in [
            format!("{{{size}, {focal}, \"cx\": 319.5, \"cy\": 239.5, \"distortion\": {k}}}"),
            // RealSense: as pyrealsense2 names it.
            format!(
                "{{\n  {size}, {focal}, \"ppx\": 319.5, \"ppy\": 239.5,\n \"model\": \"distortion.brown_conrady\", \"coeffs\": {k}}}"
            ),
"width: 640\nheight: 480\nfx: 500\nfy: 501\nppx: 319.5\nppy: 239.5\ncoeffs:\n - 0.1\n - -0.2\n - 0.001\n - 0.002\n".to_owned(),
            format!(
                "{{{size}, \"intrinsics\": {{{focal}, \"cx\": 319.5, \"cy\": 239.5}}, \"dist_coeffs\": [{k}]}}"
            ),
            format!(
                "{{\"color\": {{{size}, \"intrinsics\": {rows}, \"dist\": {k}}}, \"depth_scale\": 0.001}}"
            ),
            format!(
                "{{\"camera\": {{\"K\": {rows}, \"D\": {k}, \"image_size\": [640, 480]}}, \"R\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}"
            ),
            format!("color:\n  K: {rows}\n  D: {k}\n  image_width: 640\n  image_height: 480\n"),
            format!(
                "{{\"resolution\": {{{size}}}, \"camera_matrix\": {{{focal}, \"cx\": 319.5, \"cy\": 239.5}}, \"distortion\": \
                 {{\"k1\": 0.1, \"k2\": -0.2, \"p1\": 0.001, \"p2\": 0.002}}}}"
            ),
        ] {
            assert_eq!(read(&text).unwrap(), ours, "{text}");
        }
        // Open3D: columns, no lens.
        let ideal = Calibration { distortion: Distortion::None, ..ours };
        for text in [
            format!("{{{size}, \"intrinsic_matrix\": {columns}}}"),
            format!(
                "{{\"class_name\": \"PinholeCameraParameters\", \"extrinsic\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], \
                 \"intrinsic\": {{{size}, \"intrinsic_matrix\": {columns}}}, \"version_major\": 1}}"
            ),
        ] {
            assert_eq!(read(&text).unwrap(), ideal, "{text}");
        }
        let fisheye = format!(
            "{{{size}, {focal}, \"ppx\": 1, \"ppy\": 2, \"model\": \"kannala_brandt4\", \"coeffs\": {k}}}"
        );
        for (text, expected) in [
            (
                format!("{{\"color\": {{{focal}}}, \"depth\": {{{focal}}}}}"),
                "expected one camera, found 2 (color, depth)",
            ),
            (format!("{{{size}, {focal}, \"cx\": 3}}"), "expected a line 'cy: NUMBER'"),
            (format!("{{{size},\n\"fx\": \"wide\"}}"), "line 2: expected a number for fx, found 'wide'"),
            (
                format!("{{{focal}, \"cx\": 1, \"cy\": 1, \"D\": {k}, \"dist\": {k}}}"),
                "of one lens, found D, dist",
            ),
            (fisheye, "line 1: expected 4 distortion coefficients, found 5"),
            ("{\"width\": 640".to_owned(), "camera.yaml"),
        ] {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error} ({expected})");
        }
    }

    #[test]
    fn a_fisheye_of_orb_slam() {
        let text = "%YAML:1.0\nCamera.type: \"KannalaBrandt8\"\nCamera1.fx: 190.9\nCamera1.fy: 190.9\nCamera1.cx: 254.9\nCamera1.cy: 256.8\n\
                    Camera1.k1: 0.003\nCamera1.k2: 0.0007\nCamera1.k3: -0.002\nCamera1.k4: 0.0002\n";
        let read = |text: &str| read(text).map(|camera| camera.distortion);
        assert_eq!(read(text), Ok(Distortion::KannalaBrandt([0.003, 0.0007, -0.002, 0.0002])));
        let error = read(&text.replace("KannalaBrandt8", "PinHole")).unwrap_err();
        assert!(error.contains("at most 5 distortion coefficients"), "{error}");
    }

    #[test]
    fn tables_of_toml() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.toml");
        let table = "model = \"radial-tangential\"\nsize_px = [640, 480] # both\nfocal_px = [500.0, 501.0]\n\
                     center_px = [319.5, 239.5]\ndistortion = [0.1, -0.2,\n  0.001, 0.002]\n";
        fs::write(&path, table).unwrap();
        let expected = Calibration { rate_hz: None, ..read(OURS).unwrap() };
        assert_eq!(read_calibration(&path).unwrap(), expected);
        fs::write(&path, table.replace("[500.0, 501.0]", "[500.0]")).unwrap();
        let error = read_calibration(&path).unwrap_err().to_string();
        assert!(error.contains("line 3") && error.contains("camera.toml"), "{error}");
        // The keys of other forms, as people write them by hand.
        let by_hand = OURS.replace(": ", " = ");
        let lens = "distortion = [0.1, -0.2, 0.001, 0.002]";
        let separate = "k1 = 0.1\nk2 = -0.2\np1 = 0.001\np2 = 0.002";
        let ours = read(OURS).unwrap();
        for text in [
            by_hand.clone(),
            format!("model = \"radtan\"\n{by_hand}"),
            format!("[camera]\n{by_hand}"),
            by_hand.replace(lens, separate),
            "image_width = 640\nimage_height = 480\nfps = 20\nK = [[500, 0, 319.5], [0, 501, 239.5], [0, 0, 1]]\n\
             D = [0.1, -0.2, 0.001, 0.002, 0]\n"
                .to_owned(),
        ] {
            fs::write(&path, &text).unwrap();
            let found = read_calibration(&path).map_err(|error| error.to_string());
            assert_eq!(found.map(|found| Calibration { rate_hz: Some(20.0), ..found }), Ok(ours.clone()), "{text}");
        }
        for (from, to, expected) in [
            ("cy = 239.5 # middle\n", "", "expected a line 'cy = NUMBER', found none"),
            ("fx = 500", "fx = \"wide\"", "line 3: expected a number for fx, found 'wide'"),
            ("width = 640", "width = 640.5", "line 1: expected width and height in whole pixels"),
            ("fps = 20", "size_px = [640, 480]", "focal_px = [fx, fy]"),
            ("fx = 500", "f = 500", "focal_px = [fx, fy]"),
        ] {
            fs::write(&path, by_hand.replace(from, to)).unwrap();
            let error = read_calibration(&path).unwrap_err().to_string();
            assert!(error.contains("camera.toml") && error.contains(expected), "{error} ({expected})");
        }
    }

    #[test]
    fn faults_are_named() {
        for (from, to, expected) in [
            ("fx: 500\n", "", "expected a line 'fx: NUMBER', found none"),
            ("fx: 500", "fx: wide", "line 3: expected a number for fx, found 'wide'"),
            ("width: 640", "width: 640.5", "line 1: expected width and height in whole pixels"),
            ("0.002]", "0.002, 0, 0]", "line 7: expected at most 5 distortion coefficients, found 6"),
            (", 0.002]", "]", "found 3, whose third may be p1 or k3"),
            ("fps: 20", "distortion_model: thin-prism", "line 8: expected distortion_model"),
        ] {
            let error = read(&OURS.replace(from, to)).unwrap_err();
            assert!(error.contains("camera.yaml") && error.contains(expected), "{error} ({expected})");
        }
        assert!(read("").is_err());
    }

    #[test]
    fn a_fisheye_is_told_by_its_model() {
        let fisheye = read(&OURS.replace("fps: 20", "distortion_model: equidistant")).unwrap();
        assert_eq!(fisheye.distortion, Distortion::KannalaBrandt([0.1, -0.2, 0.001, 0.002]));
    }
}
