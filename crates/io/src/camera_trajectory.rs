//! Trajectories of a camera in text files of the three usual forms, and as a table of visloc.
//!
//! * TUM: `t tx ty tz qx qy qz qw`, seconds and meters.
//! * KITTI: a 3 x 4 matrix in each line, row by row, and no times: line n gets the time n seconds, from 0.
//! * EuRoC: a table `t,x,y,z,qw,qx,qy,qz,...`, whole nanoseconds and meters.
//! * `visloc localize --estimates` in a map of SLAM: a table whose first line is `t,x,y,z,qx,qy,qz,qw,...`, seconds.
//!   Lines with a 0 in the column `localized` are no poses to rely on, and are passed over, as `--trajectory` does.
//!
//! All say where the camera (or body) is in the world: its pose takes points of the camera to the world.

use std::{
    io::{self, Write},
    path::Path,
};

use nalgebra::{Matrix3, Rotation3, Vector3};
use visloc_core::{
    CameraPose, CameraTrajectory, SkippedInput, Timestamp,
    files::{self, NewFile},
    geom::{CameraFrame, Rigid3, World},
};

use crate::{
    FileError,
    text::{data_lines, parse_nanos, parse_number, parse_secs},
};

/// How the poses of a file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrajectoryFormat {
    /// `t tx ty tz qx qy qz qw`.
    Tum,
    /// Twelve numbers of a matrix, no times.
    Kitti,
    /// `t,x,y,z,qw,qx,qy,qz,...`, nanoseconds.
    Euroc,
    /// `t,x,y,z,qx,qy,qz,qw,...`, seconds, below a line of these names.
    Table,
}

/// A trajectory as it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraTrajectoryFile {
    /// The poses.
    pub trajectory: CameraTrajectory,
    /// How they were written.
    pub format: TrajectoryFormat,
    /// Whether it says of itself that its unit of length is that of a map without scale.
    pub is_in_map_units: bool,
    /// Whether it says of itself that it is a camera's, or has the form of such.
    pub is_of_camera: bool,
    /// Lines whose time is not after the one before; even published truths have some. Of poses of the same time the last
    /// counts, as in `evo`; earlier ones are left out.
    pub skipped: Vec<SkippedInput>,
}

impl CameraTrajectoryFile {
    /// The poses with times; those of a KITTI file, which has none, with the times beside it.
    ///
    /// # Errors
    /// If there are none, or if they cannot be read.
    pub fn timed(self, path: &Path) -> Result<CameraTrajectory, FileError> {
        if self.format != TrajectoryFormat::Kitti {
            return Ok(self.trajectory);
        }
        let poses = self.trajectory.poses();
        let Some(times) = kitti_times(path, poses.len())? else {
            let times = path.with_file_name("times.txt");
            let reason = format!(
                "expected poses with times, found twelve numbers a line (KITTI); put the times into {}, one a line",
                times.display()
            );
            return Err(FileError::form(path, reason));
        };
        let mut timed = CameraTrajectory::new();
        for (pose, at) in poses.iter().zip(times) {
            // In order, as they were read.
            let _ = timed.push(CameraPose { at, ..*pose });
        }
        Ok(timed)
    }
}

/// Reads camera poses; the format is told from the first line that is neither empty nor a comment. Of poses of
/// the same time the last counts; poses that go back in time are left out.
///
/// # Errors
/// If the file cannot be read or a line is not in the format; with the number of the line.
pub fn read_camera_trajectory(path: &Path) -> Result<CameraTrajectory, FileError> {
    read_camera_trajectory_file(path).map(|file| file.trajectory)
}

/// As [`read_camera_trajectory`], with the format that was found and what was left out.
///
/// # Errors
/// As [`read_camera_trajectory`].
pub fn read_camera_trajectory_file(path: &Path) -> Result<CameraTrajectoryFile, FileError> {
    let text = files::read_text(path).map_err(FileError::io(path))?;
    let first =
        data_lines(&text).next().ok_or_else(|| FileError::form(path, "expected poses, found none"))?;
    let format = recognize(first.1).map_err(FileError::line(path, first.0))?;
    let (mut poses, mut skipped): (Vec<CameraPose>, _) = (Vec::new(), Vec::new());
    let is_table = format == TrajectoryFormat::Table;
    let localized = first.1.split(',').position(|name| is_table && name.trim() == "localized");
    let is_wanted = |line: &str| {
        localized.and_then(|column| line.split(',').nth(column)).is_none_or(|value| value.trim() != "0")
    };
    let lines = data_lines(&text).skip(usize::from(is_table)).filter(|(_, line)| is_wanted(line));
    for (count, (number, line)) in lines.enumerate() {
        let pose = match format {
            TrajectoryFormat::Tum => {
                parse_tum(line).map(|(at, world_from_camera)| CameraPose { at, world_from_camera })
            }
            TrajectoryFormat::Kitti => parse_kitti(line).map(|world_from_camera| CameraPose {
                at: Timestamp::from_nanos(count as i64 * 1_000_000_000),
                world_from_camera,
            }),
            TrajectoryFormat::Euroc => parse_euroc(line),
            TrajectoryFormat::Table => parse_table(line),
        };
        let pose = pose.map_err(FileError::line(path, number))?;
        match poses.last_mut() {
            Some(last) if last.at >= pose.at => {
                skipped.push(SkippedInput {
                    at: Some(pose.at),
                    origin: format!("{}: line {number}", path.display()),
                    reason: format!("expected a time after {}, found {}", last.at, pose.at),
                });
                if last.at == pose.at {
                    *last = pose;
                }
            }
            _ => poses.push(pose),
        }
    }
    let mut trajectory = CameraTrajectory::new();
    for pose in poses {
        // In order by now.
        let _ = trajectory.push(pose);
    }
    let says =
        |what: &str| text.lines().take_while(|line| line.starts_with('#')).any(|line| line.contains(what));
    let is_of_camera =
        matches!(format, TrajectoryFormat::Kitti | TrajectoryFormat::Table) || says(CAMERA_TO_WORLD);
    Ok(CameraTrajectoryFile { is_in_map_units: says(MAP_UNITS), is_of_camera, trajectory, format, skipped })
}

/// The times of the poses of a KITTI file by `times.txt`: beside `poses.txt`, or in `sequences/06` beside the folder of `poses/06.txt`, as
/// the benchmark has it. `None` if there is no such file.
fn kitti_times(poses: &Path, num_poses: usize) -> Result<Option<Vec<Timestamp>>, FileError> {
    let beside = poses.with_file_name("times.txt");
    let of_benchmark = || {
        let sequences = poses.parent()?.parent()?.join("sequences");
        Some(sequences.join(poses.file_stem()?).join("times.txt"))
    };
    let Some(path) = [Some(beside), of_benchmark()].into_iter().flatten().find(|path| files::is_there(path))
    else {
        return Ok(None);
    };
    let times = read_times(&path)?;
    if times.len() < num_poses {
        let reason = format!("expected a time for each of {num_poses} poses, found {}", times.len());
        return Err(FileError::form(&path, reason));
    }
    Ok(Some(times))
}

/// Times in seconds, one in each line, each after the one before.
pub(crate) fn read_times(path: &Path) -> Result<Vec<Timestamp>, FileError> {
    let text = files::read_text(path).map_err(FileError::io(path))?;
    let mut stamps: Vec<Timestamp> = Vec::new();
    for (number, line) in data_lines(&text) {
        let at = parse_secs(line).map_err(FileError::line(path, number))?;
        if let Some(last) = stamps.last().filter(|last| **last >= at) {
            let reason = format!("expected a time after {last}, found {at}");
            return Err(FileError::line(path, number)(reason));
        }
        stamps.push(at);
    }
    Ok(stamps)
}

/// The first columns of a table of visloc.
const TABLE: [&str; 8] = ["t", "x", "y", "z", "qx", "qy", "qz", "qw"];

fn recognize(line: &str) -> Result<TrajectoryFormat, String> {
    let (columns, fields) = (line.split(',').count(), line.split_whitespace().count());
    match (columns, fields) {
        (8.., _) if line.split(',').map(str::trim).zip(TABLE).all(|(name, column)| name == column) => {
            Ok(TrajectoryFormat::Table)
        }
        (8.., _) => Ok(TrajectoryFormat::Euroc),
        (1, 8) => Ok(TrajectoryFormat::Tum),
        (1, 12) => Ok(TrajectoryFormat::Kitti),
        _ => Err(format!(
            "expected 8 numbers (t tx ty tz qx qy qz qw), 12 numbers (a 3 x 4 matrix) or a table t,x,y,z,qw,qx,qy,qz, \
             found '{line}'"
        )),
    }
}

fn numbers<const N: usize>(fields: &[&str]) -> Result<[f64; N], String> {
    if fields.len() < N {
        return Err(format!("expected {N} numbers, found {}", fields.len()));
    }
    let mut numbers = [0.0; N];
    for (number, field) in numbers.iter_mut().zip(fields) {
        *number = parse_number(field)?;
    }
    Ok(numbers)
}

fn rigid<Dst, Src>([qx, qy, qz, qw]: [f64; 4], position: [f64; 3]) -> Result<Rigid3<Dst, Src>, String> {
    Rigid3::from_quaternion([qx, qy, qz, qw], position)
        .ok_or_else(|| format!("expected a quaternion of length 1, found {qx} {qy} {qz} {qw}"))
}

/// A line of a file in TUM format: time, position, quaternion.
pub(crate) fn parse_tum<Src>(line: &str) -> Result<(Timestamp, Rigid3<World, Src>), String> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    let [stamp, values @ ..] = fields.as_slice() else { return Err("expected a pose".to_owned()) };
    if values.len() != 7 {
        return Err(format!("expected 8 numbers (t tx ty tz qx qy qz qw), found {}", fields.len()));
    }
    let [x, y, z, qx, qy, qz, qw] = numbers(values)?;
    Ok((parse_secs(stamp)?, rigid([qx, qy, qz, qw], [x, y, z])?))
}

fn parse_euroc(line: &str) -> Result<CameraPose, String> {
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    let [stamp, values @ ..] = fields.as_slice() else { return Err("expected a pose".to_owned()) };
    let [x, y, z, qw, qx, qy, qz] = numbers(values)?;
    Ok(CameraPose { at: parse_nanos(stamp)?, world_from_camera: rigid([qx, qy, qz, qw], [x, y, z])? })
}

fn parse_table(line: &str) -> Result<CameraPose, String> {
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    let [stamp, values @ ..] = fields.as_slice() else { return Err("expected a pose".to_owned()) };
    let [x, y, z, qx, qy, qz, qw] = numbers(values)?;
    Ok(CameraPose { at: parse_secs(stamp)?, world_from_camera: rigid([qx, qy, qz, qw], [x, y, z])? })
}

/// A pose as the rows of a 3 x 4 matrix.
pub(crate) fn parse_kitti(line: &str) -> Result<Rigid3<World, CameraFrame>, String> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    if fields.len() != 12 {
        return Err(format!("expected 12 numbers (a 3 x 4 matrix), found {}", fields.len()));
    }
    let m: [f64; 12] = numbers(&fields)?;
    let rotation = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
    let is_rotation = (rotation.transpose() * rotation - Matrix3::identity()).norm() < 1e-3;
    if !is_rotation || rotation.determinant() < 0.0 {
        return Err(format!("expected the matrix of a rotation, found {:?}", &m));
    }
    Ok(Rigid3::new(Rotation3::from_matrix_unchecked(rotation), Vector3::new(m[3], m[7], m[11])))
}

/// What the first line says of a unit of length that is not known, and of whose poses they are.
const MAP_UNITS: &str = "map units";
const CAMERA_TO_WORLD: &str = "camera to world";

/// Writes camera poses in TUM format; the unit of length is the meter or not known.
///
/// # Errors
/// If the file cannot be written.
pub fn write_camera_trajectory(path: &Path, poses: &[CameraPose], is_metric: bool) -> Result<(), FileError> {
    let unit = if is_metric { "m" } else { MAP_UNITS };
    let mut out = NewFile::create(path).map_err(FileError::io(path))?;
    let write = move || -> io::Result<()> {
        writeln!(out, "# t_s tx ty tz qx qy qz qw, {CAMERA_TO_WORLD}, {unit}")?;
        for pose in poses {
            let t = pose.world_from_camera.translation();
            let [x, y, z, w] = pose.world_from_camera.quaternion_xyzw();
            writeln!(out, "{} {:.9} {:.9} {:.9} {x:.12} {y:.12} {z:.12} {w:.12}", pose.at, t.x, t.y, t.z)?;
        }
        out.finish()
    };
    write().map_err(FileError::io(path))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn read(text: &str) -> Result<CameraTrajectoryFile, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        fs::write(&path, text).unwrap();
        read_camera_trajectory_file(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn four_formats_of_the_same_pose() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let tum = format!("# t\n2.5 1 2 3 0 0 {half} {half}\n");
        let euroc = format!("#timestamp,x,...\n2500000000,1,2,3,{half},0,0,{half},0,0,0\n");
        let kitti = "0 -1 0 1 1 0 0 2 0 0 1 3\n";
        let table = format!(
            "t,x,y,z,qx,qy,qz,qw,map,localized\n2,9,9,9,0,0,0,1,0,0\n2.5,1,2,3,0,0,{half},{half},0,1\n"
        );
        let (tum, euroc, kitti) = (read(&tum).unwrap(), read(&euroc).unwrap(), read(kitti).unwrap());
        let table = read(&table).unwrap();
        assert_eq!(
            [tum.format, euroc.format, kitti.format, table.format],
            [
                TrajectoryFormat::Tum,
                TrajectoryFormat::Euroc,
                TrajectoryFormat::Kitti,
                TrajectoryFormat::Table
            ]
        );
        for file in [&euroc, &table] {
            assert_eq!(tum.trajectory.poses()[0].at, file.trajectory.poses()[0].at);
        }
        let turn = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        for file in [&tum, &euroc, &kitti, &table] {
            let pose = file.trajectory.poses()[0].world_from_camera;
            assert!((pose.rotation() - turn).norm() < 1e-12);
            assert_eq!(*pose.translation(), Vector3::new(1.0, 2.0, 3.0));
        }
    }

    #[test]
    fn written_poses_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.tum");
        let pose = CameraPose {
            at: Timestamp::from_nanos(1_700_000_000_033_333_333),
            world_from_camera: Rigid3::from_quaternion([0.1, -0.2, 0.3, 0.9], [1.5, -2.5, 3.5]).unwrap(),
        };
        for is_metric in [true, false] {
            write_camera_trajectory(&path, &[pose], is_metric).unwrap();
            assert_eq!(read_camera_trajectory_file(&path).unwrap().is_in_map_units, !is_metric);
        }
        let back = read_camera_trajectory(&path).unwrap().poses()[0];
        assert_eq!(back.at, pose.at);
        assert!((back.world_from_camera.rotation() - pose.world_from_camera.rotation()).norm() < 1e-10);
    }

    #[test]
    fn repeated_and_earlier_poses_are_left_out() {
        let file = read("1 0 0 0 0 0 0 1\n1 5 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n0.5 9 0 0 0 0 0 1\n").unwrap();
        assert_eq!(file.trajectory.poses().len(), 2);
        assert_eq!(file.trajectory.poses()[0].world_from_camera.translation().x, 5.0);
        assert!(file.skipped[0].origin.ends_with("line 2") && file.skipped[1].origin.ends_with("line 4"));
        assert!(file.skipped[0].reason.starts_with("expected a time after 1.0"));
    }

    #[test]
    fn faults_are_named_with_their_line() {
        let good = "1 0 0 0 0 0 0 1\n";
        for (text, expected) in [
            (format!("{good}2 0 0 x 0 0 0 1\n"), "line 2: expected a finite number, found 'x'"),
            (format!("{good}2 0 0 0 0 0 0 0\n"), "quaternion"),
            (format!("{good}2 0 0 0 0 0 1\n"), "line 2: expected 8 numbers"),
            ("1 2 3\n".to_owned(), "line 1: expected 8 numbers"),
            ("2 0 0 0 0 2 0 0 0 0 2 0\n".to_owned(), "line 1: expected the matrix of a rotation"),
            ("a,0,0,0,1,0,0,0\n".to_owned(), "line 1: expected a time in whole nanoseconds, found 'a'"),
            ("t,x,y,z,qx,qy,qz,qw\n1,0,0,0,0,0,1\n".to_owned(), "line 2: expected 7 numbers, found 6"),
            ("# nothing\n".to_owned(), "expected poses, found none"),
        ] {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error} (expected {expected})");
        }
    }
}
