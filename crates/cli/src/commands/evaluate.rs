//! `visloc evaluate`: an estimated trajectory against the truth.

use std::path::Path;

use anyhow::{Context, Result, bail};
use visloc_core::eval::{EstimateSample, EvaluationOptions, evaluate};
use visloc_io::trajectory::read_trajectory;
use visloc_world::Map;

use super::evaluate_camera;
use crate::{
    args::EvaluateArgs,
    report::{Column, Curve, EvaluationReport, RunPictures, comparison_table, save_json},
    run::Saving,
    say,
    settings::read_text,
};

/// Runs the command.
pub fn execute(args: &EvaluateArgs) -> Result<()> {
    if evaluate_camera::is_meant(args) {
        if args.map.is_some() {
            bail!("--map: belongs to a robot on the ground, found a camera in space; leave it out");
        }
        return evaluate_camera::execute(args);
    }
    if let Some(flag) = args.camera.given() {
        bail!("{flag}: belongs to a camera in space, found --as robot; leave one of the two out");
    }
    let truth = read_trajectory(&args.truth)?;
    let samples = read_estimate(&args.estimate)?;
    let map = args.map.as_deref().map(Map::load).transpose()?;
    let evaluation = evaluate(&truth, &samples, &EvaluationOptions::default());
    if evaluation.frames == 0 {
        bail!(
            "{}: none of its {} poses is within {} s of a pose of {}; are both of the same run?",
            args.estimate.display(),
            samples.len(),
            EvaluationOptions::default().stamp_tolerance_secs,
            args.truth.display()
        );
    }
    let report = EvaluationReport::of(&evaluation);
    say::line!("{} in common\n", say::count(evaluation.frames, "frame"));
    let label =
        args.estimate.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    say::text(format_args!("{}", comparison_table(&[Column { title: &label, report: &report }])));
    let mut saving = Saving::default();
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.save_if(args.plots.as_deref(), |folder| {
        let pictures = RunPictures {
            title: label.clone(),
            subtitle: format!("{} against {}", args.estimate.display(), args.truth.display()),
            map: map.as_ref(),
            truth: &truth,
            curves: vec![Curve {
                label: &label,
                samples,
                comparison: Some(&evaluation),
                individuals: Vec::new(),
            }],
        };
        pictures.save(folder)?;
        say::line!("\npictures: {}", folder.display());
        Ok(())
    });
    saving.end()
}

/// A trajectory, with the reliabilities if the file is a table that has them.
fn read_estimate(path: &Path) -> Result<Vec<EstimateSample>> {
    let trajectory = read_trajectory(path)?;
    let reliabilities = reliabilities_in(path)?;
    let samples = trajectory.poses().iter().enumerate().map(|(i, pose)| EstimateSample {
        at: pose.at,
        world_from_robot: pose.world_from_robot,
        reliability: reliabilities.as_ref().and_then(|values| values.get(i).copied()),
    });
    Ok(samples.collect())
}

/// The column `reliability`, one value for each pose of the same file.
pub fn reliabilities_in(path: &Path) -> Result<Option<Vec<f64>>> {
    let text = read_text(path)?;
    let is_data = |line: &str| !line.is_empty() && !line.starts_with('#');
    let mut lines = text.lines().map(str::trim).enumerate().filter(|(_, line)| is_data(line));
    let Some((_, header)) = lines.next() else { return Ok(None) };
    let Some(column) = header.split(',').position(|name| name.trim() == "reliability") else {
        return Ok(None);
    };
    let value = |(i, line): (usize, &str)| {
        let field = line.split(',').nth(column).unwrap_or_default().trim();
        let value: Option<f64> = field.parse().ok().filter(|value| (0.0..=1.0).contains(value));
        value.with_context(|| {
            format!("{}, line {}: expected a reliability from 0 to 1, found '{field}'", path.display(), i + 1)
        })
    };
    lines.map(value).collect::<Result<Vec<_>>>().map(Some)
}
