//! Frames with another mounting of the camera or other odometry than the recording says.

use std::path::Path;

use anyhow::{Context, Result};
use visloc_core::{Mapped, Source, SourceFrame};
use visloc_locate::robot_calibration::{OdometryCorrector, RobotCorrection};

use super::write_text;
use crate::{args::CorrectionArgs, say, settings::from_toml};

/// The source with the corrections that the arguments name.
pub fn corrected(
    inner: Box<dyn Source<SourceFrame>>,
    args: &CorrectionArgs,
) -> Result<Box<dyn Source<SourceFrame>>> {
    let robot = read_correction(args)?;
    if robot == RobotCorrection::default() {
        return Ok(inner);
    }
    Ok(with_correction(inner, robot))
}

/// The source with corrections.
pub fn with_correction(
    inner: Box<dyn Source<SourceFrame>>,
    robot: RobotCorrection,
) -> Box<dyn Source<SourceFrame>> {
    let mut odometry = OdometryCorrector::default();
    Box::new(Mapped::new(inner, move |mut source: SourceFrame| {
        let frame = &mut source.frame;
        // What is known is the error of the first camera.
        if frame.camera_index == 0 {
            frame.robot_from_camera = robot.camera.apply(&frame.robot_from_camera);
        }
        frame.odometry = frame.odometry.map(|odom| odometry.step(&odom, &robot.odometry));
        Ok(source)
    }))
}

/// The corrections of the file that the arguments name; none without a file.
pub fn read_correction(args: &CorrectionArgs) -> Result<RobotCorrection> {
    let Some(path) = &args.robot else { return Ok(RobotCorrection::default()) };
    let robot: RobotCorrection = from_toml(path)?;
    robot.check().with_context(|| path.display().to_string())?;
    Ok(robot)
}

/// Writes corrections for later runs.
pub fn write_correction(path: &Path, robot: &RobotCorrection, writer: &str) -> Result<()> {
    let head = format!(
        "# What is always wrong with this robot, for visloc localize --robot. Written by {writer}.\n"
    );
    write_text(path, &(head + &toml::to_string(robot)?))?;
    say::line!("corrections: {}", path.display());
    Ok(())
}
