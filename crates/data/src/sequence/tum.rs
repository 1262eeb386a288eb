//! The layout of the TUM RGB-D benchmark: `rgb.txt` names the images, `groundtruth.txt` has the poses.

use std::{
    fs,
    io::{self, Write},
    path::Path,
};

use visloc_base::{CameraPose, CameraTrajectory, SkippedInput, Timestamp};
use visloc_geom::Rigid3;

use super::{FileSequence, ImageFile, SequenceError, SequenceRange, calibration::read_camera_yaml};

/// Opens a folder with `rgb.txt` and `camera.yaml`. Lines of `rgb.txt` that cannot be read, or whose time is not after the one
/// before, are left out and noted.
///
/// # Errors
/// If one of the two files is missing, the calibration is wrong, or there is no image.
pub fn open_tum(folder: &Path, range: SequenceRange) -> Result<FileSequence, SequenceError> {
    let camera = read_camera_yaml(&folder.join("camera.yaml"))?;
    let list = folder.join("rgb.txt");
    let text =
        fs::read_to_string(&list).map_err(|source| SequenceError::Io { path: list.clone(), source })?;
    let (mut files, mut skipped): (Vec<ImageFile>, _) = (Vec::new(), Vec::new());
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let last = files.last().map(|file| file.at);
        match parse_image_line(line, last) {
            Ok((at, name)) => files.push(ImageFile { at, path: folder.join(name) }),
            Err(reason) => {
                let origin = format!("{}, line {}", list.display(), i + 1);
                skipped.push(SkippedInput { at: None, origin, reason });
            }
        }
    }
    if files.is_empty() {
        return Err(SequenceError::Layout {
            path: list,
            reason: "expected lines 'SECONDS FILE', found none".to_owned(),
        });
    }
    Ok(FileSequence::new(camera, files, range, skipped))
}

fn parse_image_line(line: &str, last: Option<Timestamp>) -> Result<(Timestamp, &str), String> {
    let (stamp, name) = line
        .split_once(char::is_whitespace)
        .ok_or_else(|| format!("expected 'SECONDS FILE', found '{line}'"))?;
    let at = parse_stamp(stamp)?;
    match last {
        Some(last) if last >= at => Err(format!("expected a time after {last}, found {at}")),
        _ => Ok((at, name.trim())),
    }
}

/// Seconds with up to nine decimals, without the rounding of a float where they are written plainly.
fn parse_stamp(text: &str) -> Result<Timestamp, String> {
    let secs: f64 = text.parse().map_err(|_| format!("expected a time in seconds, found '{text}'"))?;
    if !(secs.is_finite() && secs.abs() < 9e9) {
        return Err(format!("expected a time in seconds, found '{text}'"));
    }
    let is_plain = text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    if is_plain
        && fraction.len() <= 9
        && let (Ok(whole), Ok(nanos)) = (whole.parse::<i64>(), format!("{fraction:0<9}").parse::<i64>())
    {
        return Ok(Timestamp::from_nanos(whole * 1_000_000_000 + nanos));
    }
    Ok(Timestamp::from_secs(secs))
}

/// Reads camera poses in TUM format: `t tx ty tz qx qy qz qw`, camera to world. Lines that start with `#` are passed over.
///
/// # Errors
/// If the file cannot be read, a line is not in the format, or time does not increase.
pub fn read_camera_trajectory(path: &Path) -> Result<CameraTrajectory, SequenceError> {
    let text =
        fs::read_to_string(path).map_err(|source| SequenceError::Io { path: path.to_path_buf(), source })?;
    let mut trajectory = CameraTrajectory::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let line_error = |reason| SequenceError::Line { path: path.to_path_buf(), line: i + 1, reason };
        let pose = parse_pose(line).map_err(line_error)?;
        trajectory
            .push(pose)
            .map_err(|refused| line_error(format!("expected increasing times, found {}", refused.at)))?;
    }
    Ok(trajectory)
}

fn parse_pose(line: &str) -> Result<CameraPose, String> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    let [stamp, values @ ..] = fields.as_slice() else { return Err("expected a pose".to_owned()) };
    let expected = || format!("expected 't tx ty tz qx qy qz qw', found '{line}'");
    let numbers: Vec<f64> = values.iter().filter_map(|v| v.parse().ok()).collect();
    let &[tx, ty, tz, qx, qy, qz, qw] = numbers.as_slice() else { return Err(expected()) };
    let world_from_camera = Rigid3::from_quaternion([qx, qy, qz, qw], [tx, ty, tz]).ok_or_else(expected)?;
    Ok(CameraPose { at: parse_stamp(stamp)?, world_from_camera })
}

/// Writes camera poses in TUM format.
///
/// # Errors
/// If the file cannot be written.
pub fn write_camera_trajectory(path: &Path, poses: &[CameraPose]) -> Result<(), SequenceError> {
    let io_error = |source: io::Error| SequenceError::Io { path: path.to_path_buf(), source };
    let mut out = io::BufWriter::new(fs::File::create(path).map_err(io_error)?);
    let mut write = || -> io::Result<()> {
        writeln!(out, "# t_s tx ty tz qx qy qz qw, camera to world, map units")?;
        for pose in poses {
            let t = pose.world_from_camera.translation();
            let [x, y, z, w] = pose.world_from_camera.quaternion_xyzw();
            writeln!(out, "{} {:.9} {:.9} {:.9} {x:.12} {y:.12} {z:.12} {w:.12}", pose.at, t.x, t.y, t.z)?;
        }
        out.flush()
    };
    write().map_err(io_error)
}
