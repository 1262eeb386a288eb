//! TUM RGB-D, and everything that lists its images in the same way: `rgb.txt` has lines `SECONDS FILE`.
//!
//! Calibration: `camera.yaml`, `calibration.yaml`, `calib.txt` or a Middlebury `*_par.txt`; recordings of the benchmark itself have
//! none, and their cameras are told by the name of the folder (`freiburg1`, `freiburg2`, `freiburg3`).
//!
//! Source: Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", 2012, and its page on file formats and
//! intrinsic calibration.

use std::path::Path;

use visloc_core::{files, geom::Distortion};

use super::{
    Contents, Layout, file_ending, first_file,
    list::{Parsed, read_list},
};
use crate::{FileError, camera_trajectory::read_camera_trajectory, sequence::Calibration, text::parse_secs};

pub(super) const LAYOUT: Layout = Layout {
    key: "tum",
    name: "TUM RGB-D",
    mark: "rgb.txt",
    is_here: |folder| files::is_there(&folder.join("rgb.txt")),
    read,
};

/// Marks in the names of the recordings, and the color cameras: fx, fy, cx, cy and distortion.
const CAMERAS: [([&str; 2], [f64; 4], [f64; 5]); 3] = [
    (["freiburg1", "fr1"], [517.3, 516.5, 318.6, 255.3], [0.2624, -0.9531, -0.0054, 0.0026, 1.1633]),
    (["freiburg2", "fr2"], [520.9, 521.0, 325.1, 249.7], [0.2312, -0.7849, -0.0033, -0.0001, 0.9172]),
    (["freiburg3", "fr3"], [535.4, 539.2, 320.1, 247.6], [0.0; 5]),
];

fn read(folder: &Path) -> Result<Contents, FileError> {
    let mut contents = Contents { calibration_file: folder.join("camera.yaml"), ..Contents::default() };
    let calibration = first_file(folder, &["camera.yaml", "calibration.yaml", "calib.txt"]);
    match calibration.or_else(|| file_ending(folder, "_par.txt")) {
        Some(file) => contents.set_calibration(file),
        None => contents.calibration = by_name(folder),
    }
    read_list(&folder.join("rgb.txt"), folder, parse_line, &mut contents)?;
    if let Some(file) = first_file(folder, &["groundtruth.txt", "groundtruth.tum"]) {
        contents.set_truth(read_camera_trajectory(&file));
    }
    Ok(contents)
}

fn parse_line(line: &str) -> Parsed<'_> {
    let (stamp, name) = line
        .split_once(char::is_whitespace)
        .ok_or_else(|| format!("expected 'SECONDS FILE', found '{line}'"))?;
    Ok((parse_secs(stamp)?, name.trim()))
}

/// The camera of a recording of the benchmark.
fn by_name(folder: &Path) -> Option<Calibration> {
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let name = folder.file_name()?.to_string_lossy().to_lowercase();
    let (_, [fx, fy, cx, cy], k) =
        CAMERAS.into_iter().find(|(marks, ..)| marks.iter().any(|mark| name.contains(mark)))?;
    Some(Calibration {
        size_px: Some((640, 480)),
        distortion: Distortion::RadialTangential(k),
        ..Calibration::pinhole((fx, fy), (cx, cy))
    })
}
