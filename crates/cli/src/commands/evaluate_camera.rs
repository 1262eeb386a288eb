//! `visloc evaluate` for a camera in space.

use std::path::Path;

use anyhow::{Result, bail};
use visloc_core::{
    CameraPose, CameraTrajectory,
    eval::camera::{Alignment, Motions, Step, absolute_error, associate, coverage, relative_errors},
    files,
};
use visloc_io::camera_trajectory::{CameraTrajectoryFile, TrajectoryFormat, read_camera_trajectory_file};

use crate::{
    args::{EvaluateArgs, TrajectoryKind},
    report::{CameraReport, camera_pictures, save_json},
    run::Saving,
    say,
};

/// Largest difference of times that belong together, seconds; that of `evo` and of the TUM tools (0.02 there).
const MAX_DIFF_SECS: f64 = 0.01;

/// Whether the arguments or the files are those of a camera.
pub fn is_meant(args: &EvaluateArgs) -> bool {
    let camera = &args.camera;
    if let Some(kind) = camera.kind {
        return kind == TrajectoryKind::Camera;
    }
    camera.given().is_some()
        || (args.map.is_none() && (is_of_camera(&args.truth) || is_of_camera(&args.estimate)))
}

/// Whether a file has poses of a camera: it says so, or they do not stand upright. False if it cannot be read, which others will say.
fn is_of_camera(path: &Path) -> bool {
    let is_tilted = |pose: &CameraPose| pose.world_from_camera.rotation()[(2, 2)] < 0.999;
    read_camera_trajectory_file(path)
        .is_ok_and(|file| file.is_of_camera || file.trajectory.poses().iter().any(is_tilted))
}

/// Whether a file is a table of poses on the ground, which has a heading and no orientation in space.
fn is_table_of_robot(path: &Path) -> bool {
    let text = files::read_text(path).unwrap_or_default();
    let header = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    header.is_some_and(|header| header.split(',').any(|name| name.trim() == "yaw"))
}

/// Runs the command.
pub fn execute(args: &EvaluateArgs) -> Result<()> {
    for (path, other) in [(&args.truth, &args.estimate), (&args.estimate, &args.truth)] {
        if is_table_of_robot(path) {
            bail!(
                "{}: a table of a robot on the ground, and {} has poses of a camera in space; expected two of the same kind \
                 (--as robot takes tilted poses for those of a robot that is lifted)",
                path.display(),
                other.display()
            );
        }
    }
    let (truth, estimate, time_label) = read_both(args)?;
    let estimate = shifted(&estimate, args.camera.offset.unwrap_or(0.0));
    let max_diff = args.camera.max_diff.unwrap_or(MAX_DIFF_SECS);
    let pairs = associate(&truth, &estimate, max_diff);
    if pairs.is_empty() {
        bail!(
            "{}: none of its {} poses is within {max_diff} s of a pose of {}; are both of the same run? (see --max-diff, --offset)",
            args.estimate.display(),
            estimate.poses().len(),
            args.truth.display()
        );
    }
    let alignment = args.camera.align.unwrap_or(Alignment::Similarity);
    let Some(absolute) = absolute_error(&pairs, alignment) else {
        bail!(
            "{}: expected at least three poses that are not on a line, for the alignment; found {} in common (see --align none)",
            args.estimate.display(),
            pairs.len()
        );
    };
    let step = args.camera.delta.map_or(Step::Frames(1), |delta| delta.0);
    let motions = if args.camera.all_pairs { Motions::All } else { Motions::Consecutive };
    let relative = relative_errors(&pairs, step, motions, &absolute.similarity);
    let report = CameraReport {
        kind: "camera",
        truth_poses: truth.poses().len(),
        estimate_poses: estimate.poses().len(),
        pairs: pairs.len(),
        coverage: coverage(&truth, &pairs),
        alignment: match alignment {
            Alignment::None => "none",
            Alignment::Rigid => "se3",
            Alignment::Similarity => "sim3",
        },
        scale: 1.0,
        ate_m: None,
        ate_rot_deg: None,
        rpe_delta: match step {
            Step::Frames(count) => count.to_string(),
            Step::Meters(meters) => format!("{meters}m"),
        },
        rpe_pairs: 0,
        rpe_trans_m: None,
        rpe_rot_deg: None,
    };
    let report = report.with_errors(&absolute, &relative);
    print(&report);
    let mut saving = Saving::default();
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.save_if(args.plots.as_deref(), |folder| {
        let title = args.estimate.display().to_string();
        camera_pictures(
            folder,
            (&title, time_label),
            (&truth, &estimate),
            &pairs,
            (&absolute, &relative, alignment),
        )?;
        say::line!("\npictures: {}", folder.display());
        Ok(())
    });
    saving.end()
}

fn read(path: &Path) -> Result<CameraTrajectoryFile> {
    let file = read_camera_trajectory_file(path)?;
    if let Some(first) = file.skipped.first() {
        say::note!(
            "{} poses with repeated or earlier times; the first: {}: {}",
            file.skipped.len(),
            first.origin,
            first.reason
        );
    }
    Ok(file)
}

/// What an axis of time shows.
const SECONDS: &str = "time [s]";

/// Truth and estimate by the same clock, and what it shows: if one of them has no times (KITTI), with those that stand beside it; if none has, by their numbers.
fn read_both(args: &EvaluateArgs) -> Result<(CameraTrajectory, CameraTrajectory, &'static str)> {
    let (truth, estimate) = (read(&args.truth)?, read(&args.estimate)?);
    if [&truth, &estimate].iter().any(|file| file.format != TrajectoryFormat::Kitti) {
        return Ok((truth.timed(&args.truth)?, estimate.timed(&args.estimate)?, SECONDS));
    }
    let (truth, estimate) = (truth.trajectory, estimate.trajectory);
    let nums = [&truth, &estimate].map(|trajectory| trajectory.poses().len());
    if nums[0] != nums[1] {
        bail!(
            "{} and {}: expected poses of the same images in files without times (KITTI), found {} and {} poses; give the estimate with times (TUM)",
            args.truth.display(),
            args.estimate.display(),
            nums[0],
            nums[1]
        );
    }
    Ok((truth, estimate, "image"))
}

fn shifted(trajectory: &CameraTrajectory, offset_secs: f64) -> CameraTrajectory {
    let mut moved = CameraTrajectory::new();
    for pose in trajectory.poses() {
        // The order stays as it is.
        let _ = moved.push(CameraPose { at: pose.at + offset_secs, ..*pose });
    }
    moved
}

fn print(report: &CameraReport) {
    say::line!(
        "{} in common of {} (truth) and {}; {} of the time covered",
        say::count(report.pairs, "pose"),
        report.truth_poses,
        report.estimate_poses,
        crate::report::percent(report.coverage)
    );
    say::line!("alignment {}, scale {:.6}\n", report.alignment, report.scale);
    say::text(format_args!("{}", report.table()));
    if report.rpe_pairs == 0 {
        say::line!("no two poses are so far apart: no relative error");
    }
}
