//! Trajectories in text files: the TUM format (`t tx ty tz qx qy qz qw`, seconds and meters) and tables with named
//! columns (`t,x,y,z,yaw,...`).

use std::{
    io::{self, Write},
    path::Path,
};

use visloc_core::{
    PlanarTrajectory, StampedPose,
    files::{self, NewFile},
    geom::{PlanarPose, Robot},
};

use crate::{
    FileError, camera_trajectory,
    text::{data_lines, parse_number, parse_secs},
};

/// Reads a trajectory of the robot's footprint. The format is recognized from the first line: a table has commas, the
/// TUM format has not. Lines that start with `#` and empty lines are passed over.
///
/// # Errors
/// If the file cannot be read, a line is not in the format, or time does not increase; with the number of the line.
pub fn read_trajectory(path: &Path) -> Result<PlanarTrajectory, FileError> {
    let io_error = |source| FileError::Io { path: path.to_path_buf(), source };
    let content = files::read_text(path).map_err(io_error)?;
    let mut trajectory = PlanarTrajectory::new();
    let mut columns: Option<Columns> = None;
    for (line, text) in data_lines(&content) {
        let line_error = |reason: String| FileError::Line { path: path.to_path_buf(), line, reason };
        let pose = match &columns {
            None if text.contains(',') => {
                columns = Some(Columns::from_header(text).map_err(line_error)?);
                continue;
            }
            None => parse_tum(text),
            Some(columns) => columns.parse(text),
        };
        let pose = pose.map_err(line_error)?;
        trajectory.push(pose).map_err(|refused| {
            let last = trajectory.poses().last().map_or(refused.at, |last| last.at);
            line_error(format!("expected a time after {last}, found {}", refused.at))
        })?;
    }
    if trajectory.poses().is_empty() {
        return Err(FileError::form(
            path,
            "expected lines of 't tx ty tz qx qy qz qw' or a table with the columns t, x, y, yaw; found no pose",
        ));
    }
    Ok(trajectory)
}

/// Writes a trajectory in the TUM format, with nanoseconds.
///
/// # Errors
/// If the file cannot be written.
pub fn write_tum(path: &Path, trajectory: &PlanarTrajectory) -> Result<(), FileError> {
    let io_error = |source| FileError::Io { path: path.to_path_buf(), source };
    let mut file = NewFile::create(path).map_err(io_error)?;
    write_tum_to(&mut file, trajectory).and_then(|()| file.finish()).map_err(io_error)
}

/// As [`write_tum`], to anything that takes bytes.
///
/// # Errors
/// If the bytes cannot be written.
pub fn write_tum_to(output: &mut impl Write, trajectory: &PlanarTrajectory) -> io::Result<()> {
    write_tum_header(output)?;
    trajectory.poses().iter().try_for_each(|pose| write_tum_pose(output, pose))
}

/// The comment at the start of a TUM file, for files that grow pose by pose.
///
/// # Errors
/// If the bytes cannot be written.
pub fn write_tum_header(output: &mut impl Write) -> io::Result<()> {
    writeln!(output, "# t_s tx_m ty_m tz_m qx qy qz qw, the robot's footprint in the map")
}

/// One line of a TUM file.
///
/// # Errors
/// If the bytes cannot be written.
pub fn write_tum_pose(output: &mut impl Write, pose: &StampedPose) -> io::Result<()> {
    let PlanarPose { x_m, y_m, yaw_rad } = pose.world_from_robot;
    let (qz, qw) = (0.5 * yaw_rad).sin_cos();
    writeln!(output, "{} {x_m:.9} {y_m:.9} {:.9} 0 0 {qz:.12} {qw:.12}", pose.at, pose.height_m)
}

fn parse_tum(text: &str) -> Result<StampedPose, String> {
    let (at, pose) = camera_trajectory::parse_tum::<Robot>(text)?;
    Ok(StampedPose { at, world_from_robot: pose.to_planar(), height_m: pose.translation().z })
}

/// Where the values stand in a table.
struct Columns {
    time: usize,
    x: usize,
    y: usize,
    yaw: usize,
    height: Option<usize>,
    num_columns: usize,
}

impl Columns {
    fn from_header(text: &str) -> Result<Self, String> {
        let names: Vec<_> = text.split(',').map(str::trim).collect();
        let find = |name: &str| names.iter().position(|known| *known == name);
        match (find("t"), find("x"), find("y"), find("yaw")) {
            (Some(time), Some(x), Some(y), Some(yaw)) => {
                Ok(Self { time, x, y, yaw, height: find("z"), num_columns: names.len() })
            }
            _ => Err(format!("expected a table with the columns t, x, y, yaw, found '{text}'")),
        }
    }

    fn parse(&self, text: &str) -> Result<StampedPose, String> {
        let fields: Vec<_> = text.split(',').map(str::trim).collect();
        if fields.len() != self.num_columns {
            return Err(format!(
                "expected {} columns as in the first line, found {}",
                self.num_columns,
                fields.len()
            ));
        }
        let number = |i: usize| parse_number(fields[i]);
        let height_m = self.height.map_or(Ok(0.0), number)?;
        let world_from_robot = PlanarPose::new(number(self.x)?, number(self.y)?, number(self.yaw)?);
        Ok(StampedPose { at: parse_secs(fields[self.time])?, world_from_robot, height_m })
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;
    use visloc_core::Timestamp;

    use super::*;

    fn read(text: &str) -> Result<PlanarTrajectory, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        fs::write(&path, text).unwrap();
        read_trajectory(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn tum_by_hand() {
        let text = "# a comment\n\n1700000000.033333333 1 2 0.25 0 0 0.7071067811865476 0.7071067811865476\n2e9 0 0 0 0 0 0 1\n";
        let trajectory = read(text).unwrap();
        let first = trajectory.poses()[0];
        assert_eq!(first.at.nanos(), 1_700_000_000_033_333_333);
        assert_eq!(
            (first.world_from_robot.x_m, first.world_from_robot.y_m, first.height_m),
            (1.0, 2.0, 0.25)
        );
        assert!((first.world_from_robot.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(trajectory.poses()[1].at.nanos(), 2_000_000_000_000_000_000);
    }

    #[test]
    fn table_by_hand() {
        let text = "t,x,y,z,yaw,carried\n1.5,1,2,0.1,-0.5,0\n1.6, 1,2,0.1,-0.5,0\n";
        let trajectory = read(text).unwrap();
        let first = StampedPose {
            at: Timestamp::from_secs(1.5),
            world_from_robot: PlanarPose::new(1.0, 2.0, -0.5),
            height_m: 0.1,
        };
        assert_eq!((trajectory.poses()[0], trajectory.poses().len()), (first, 2));
    }

    #[test]
    fn faults_are_named_with_their_line() {
        let good = "1 0 0 0 0 0 0 1\n";
        let cases = [
            (format!("{good}1 0 0 0 0 0 0 1\n"), "line 2: expected a time after 1.0"),
            (format!("{good}0.5 0 0 0 0 0 0 1\n"), "line 2: expected a time after 1.0"),
            (
                format!("{good}2 0 0 0 0 0 1\n"),
                "line 2: expected 8 numbers (t tx ty tz qx qy qz qw), found 7",
            ),
            (format!("#\n{good}2 nan 0 0 0 0 0 1\n"), "line 3: expected a finite number, found 'nan'"),
            (format!("{good}2 0 0 0 0 0 0 0\n"), "quaternion"),
            ("t,x,y\n1,2,3\n".into(), "columns t, x, y, yaw"),
            ("t,x,y,yaw\n1,2,3\n".into(), "line 2: expected 4 columns as in the first line, found 3"),
            ("1e18 0 0 0 0 0 0 1\n".into(), "expected a time in seconds"),
            ("# nothing\n".into(), "found no pose"),
        ];
        for (text, expected) in cases {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error} (expected {expected})");
        }
        let error = read_trajectory(Path::new("/nowhere/poses.txt")).unwrap_err().to_string();
        assert!(error.contains("/nowhere/poses.txt"), "{error}");
    }

    proptest! {
        #[test]
        fn written_poses_come_back(parts in prop::collection::vec((1..1_000_000_000_i64, -9.0..9.0f64, -3.1..3.1f64), 1..20)) {
            let mut trajectory = PlanarTrajectory::new();
            let mut nanos = -1_000_000_000;
            for (step, x_m, yaw_rad) in parts {
                nanos += step;
                let world_from_robot = PlanarPose::new(x_m, -x_m, yaw_rad);
                trajectory.push(StampedPose { at: Timestamp::from_nanos(nanos), world_from_robot, height_m: 0.5 }).unwrap();
            }
            let mut bytes = Vec::new();
            write_tum_to(&mut bytes, &trajectory).unwrap();
            let back = read(&String::from_utf8(bytes).unwrap()).unwrap();
            prop_assert_eq!(back.poses().len(), trajectory.poses().len());
            for (a, b) in trajectory.poses().iter().zip(back.poses()) {
                prop_assert_eq!(a.at, b.at);
                prop_assert!(a.world_from_robot.distance_m(&b.world_from_robot) < 1e-8);
                prop_assert!(a.world_from_robot.heading_difference_rad(&b.world_from_robot) < 1e-9);
            }
        }
    }
}
