//! Runs for accuracy: in this process, several at the same time, each in sequence.

use std::{
    collections::BTreeMap,
    sync::atomic::{AtomicUsize, Ordering},
};

use anyhow::{Context, Result, bail};
use clap::Parser;
use rayon::prelude::*;
use visloc_core::{
    CameraTrajectory, PlanarTrajectory, Timestamp,
    eval::{
        Evaluation, EvaluationOptions,
        camera::{AbsoluteError, associate},
    },
    geom::PlanarPose,
    median,
};
use visloc_io::{
    camera_trajectory::read_camera_trajectory,
    sources::{OpenImages, SourceOption, SourceOptions, TopicOptions, open_images},
};
use visloc_slam::Schedule;

use super::{
    plan::{Plan, Run},
    quantities::{Quantity, WRONG_CLAIM_M},
    store::{Cell, Store},
};
use crate::{
    args::{Cli, Command, LocalizeArgs, SlamArgs},
    host::host,
    report::AlgorithmReport,
    run::{FrameRecord, Progress, RunOutcome, Runner, RunnerSettings, drive, open_source, source_options},
    say::one_line,
    settings::{SlamJob, pipeline_config, slam_config, start_prior},
    slam::{Lookers, POSE_TOLERANCE_SECS, RunOptions, SlamReport, SlamRun, range_of, run},
};

/// Points of a way that are kept for pictures.
const MAX_POINTS: usize = 300;

/// Does the runs that are not there yet, and returns what did not work, with the reason.
pub fn measure_accuracy(plan: &Plan<'_>, store: &Store) -> Result<Vec<(String, String)>> {
    let progress = Progress::runs();
    let missing: Vec<Vec<&Run<'_>>> = plan
        .accuracy
        .iter()
        .map(|group| group.iter().filter(|run| store.find(&run.key).is_none()).collect())
        .collect();
    let num_done = AtomicUsize::new(plan.runs().count() - missing.iter().flatten().count());
    progress.set(num_done.load(Ordering::Relaxed), plan.runs().count());
    let measure = |group: &Vec<&Run<'_>>| -> Result<Option<(String, String)>> {
        if group.is_empty() || host().is_stopped() {
            return Ok(None);
        }
        let measured = measure_group(group);
        if host().is_stopped() {
            return Ok(None);
        }
        progress.set(num_done.fetch_add(group.len(), Ordering::Relaxed) + group.len(), plan.runs().count());
        match measured {
            Ok(cells) => cells.iter().try_for_each(|cell| store.add(cell)).map(|()| None),
            Err(error) => Ok(Some((group[0].key.words.join(" "), one_line(&error)))),
        }
    };
    let failures: Vec<_> = missing.par_iter().map(measure).collect::<Result<_>>()?;
    progress.clear();
    Ok(failures.into_iter().flatten().collect())
}

/// Runs on the same images.
fn measure_group(group: &[&Run<'_>]) -> Result<Vec<Cell>> {
    let commands = group.iter().map(|run| {
        let words = std::iter::once("visloc").chain(run.key.words.iter().map(String::as_str));
        Ok(Cli::try_parse_from(words).context(run.key.words.join(" "))?.command)
    });
    let mut localizations = Vec::new();
    let mut cells = Vec::new();
    for (run, command) in group.iter().zip(commands.collect::<Result<Vec<_>>>()?) {
        match command {
            Command::Localize(args) => localizations.push((*run, args)),
            Command::Slam(args) => cells.push(follow(run, &args)?),
            _ => bail!("{}: expected localize or slam", run.key.words.join(" ")),
        }
    }
    cells.extend(localize(&localizations)?);
    Ok(cells)
}

/// All settings see the same frames, which are read or drawn once.
fn localize(runs: &[(&Run<'_>, Box<LocalizeArgs>)]) -> Result<Vec<Cell>> {
    let Some((_, first)) = runs.first() else { return Ok(Vec::new()) };
    let mut options = SourceOptions {
        seed: first.seed.given,
        honored_elsewhere: vec![SourceOption::Seed],
        ..source_options(&first.options, TopicOptions::default())?
    };
    options.usual.num_threads = 1;
    options.usual.max_frames = first.frames.map(|frames| frames as usize);
    let mut source = open_source(&first.source, first.map.as_deref(), &options)?;
    let mut runners = Vec::new();
    for (_, args) in runs {
        let mut pipeline = pipeline_config(args.pipeline.as_deref(), &[])?;
        if let Some(features) = args.features {
            pipeline.features = features;
        }
        let settings = RunnerSettings {
            algorithm: &args.algorithm,
            algorithm_toml: None,
            pipeline,
            start: start_prior(&args.start, &source.map)?,
            seed: args.seed.value(),
        };
        runners.push(Runner::new(&source.map, &settings)?);
    }
    let outcome = drive(source.frames.as_mut(), first.frames, &mut runners, &mut []);
    if let Some(error) = &outcome.error {
        bail!("{error}");
    }
    runs.iter().zip(&runners).map(|((run, _), runner)| localization_cell(run, runner, &outcome)).collect()
}

fn localization_cell(run: &Run<'_>, runner: &Runner, outcome: &RunOutcome) -> Result<Cell> {
    let report = AlgorithmReport::new(runner, outcome);
    let evaluation = report.comparison.context("expected a truth in the recording, found none")?;
    let mut cell =
        Cell { key: run.key.clone(), figures: figures(&evaluation), truth: Vec::new(), estimate: Vec::new() };
    (cell.truth, cell.estimate) = planar_ways(&outcome.truth, runner.records());
    Ok(cell)
}

/// The figures of a robot on its map.
fn figures(evaluation: &Evaluation) -> BTreeMap<Quantity, f64> {
    let claims: Vec<_> = evaluation.frame_errors.iter().filter(|f| f.is_localized && !f.is_carried).collect();
    let num_wrong = claims.iter().filter(|frame| frame.position_error_m > WRONG_CLAIM_M).count();
    let kidnaps = &evaluation.kidnaps;
    let share = |part: usize, whole: usize| (whole > 0).then(|| part as f64 / whole as f64);
    let figures = [
        (Quantity::PositionM, evaluation.position_error_m.mean),
        (Quantity::ClaimedPositionM, evaluation.tracking_position_error_m.mean),
        (Quantity::ClaimedMedianM, evaluation.tracking_position_error_m.median),
        (Quantity::HeadingDeg, evaluation.heading_error_deg.mean),
        (Quantity::Coverage, evaluation.localized_share),
        (Quantity::WrongClaims, share(num_wrong, claims.len())),
        (Quantity::FirstClaimS, evaluation.time_to_localize_s),
        (Quantity::KidnapsFound, share(kidnaps.iter().filter(|k| k.recovered).count(), kidnaps.len())),
        (Quantity::RecoveryS, median(kidnaps.iter().filter_map(|kidnap| kidnap.recovery_s))),
    ];
    figures.into_iter().filter_map(|(quantity, value)| Some((quantity, value?))).collect()
}

/// True places, and estimates of the same times; `None` where there is none.
type Ways = (Vec<Option<[f64; 3]>>, Vec<Option<[f64; 3]>>);

/// Some of the true places, and the estimates of these times.
fn ways(truth: &[(Timestamp, Option<[f64; 3]>)], estimates: &BTreeMap<Timestamp, [f64; 3]>) -> Ways {
    let step = truth.len().div_ceil(MAX_POINTS).max(1);
    truth.iter().step_by(step).map(|(at, place)| (*place, estimates.get(at).copied())).unzip()
}

/// The way on the ground, and what was claimed.
fn planar_ways(truth: &PlanarTrajectory, records: &[FrameRecord]) -> Ways {
    let place = |pose: &PlanarPose| [pose.x_m, pose.y_m, 0.0];
    let max_height_m = EvaluationOptions::default().max_ground_height_m;
    let truth = truth.poses().iter().map(|pose| {
        let is_on_ground = pose.height_m <= max_height_m;
        (pose.at, is_on_ground.then(|| place(&pose.world_from_robot)))
    });
    let claims = records.iter().filter(|record| record.is_localized());
    let claims = claims.map(|record| (record.at, place(&record.world_from_robot)));
    ways(&truth.collect::<Vec<_>>(), &claims.collect())
}

/// A camera without a map.
fn follow(run_of: &Run<'_>, args: &SlamArgs) -> Result<Cell> {
    let config = slam_config(&args.parameters, SlamJob::Map)?;
    let mut options = SourceOptions {
        range: range_of(args),
        seed: args.seed.given,
        honored_elsewhere: vec![SourceOption::Seed],
        ..source_options(&args.options, TopicOptions::default())?
    };
    options.usual.num_threads = 1;
    let OpenImages { mut images, truth, .. } = open_images(&args.source, &options, host())?;
    let beside = run_of.recording.truth_beside.as_deref().map(read_camera_trajectory).transpose()?;
    let truth = truth.or(beside).context("expected a truth in the recording, found none")?;
    let options = RunOptions {
        seed: args.seed.value(),
        schedule: Schedule::Sequential,
        is_quiet: true,
        ..RunOptions::default()
    };
    let run = run(images.as_mut(), &config, options, Lookers::default())?;
    if let Some(error) = &run.error {
        bail!("{error}");
    }
    let (report, error) = SlamReport::new(&run, Some(&truth));
    let mut cell =
        Cell { key: run_of.key.clone(), figures: BTreeMap::new(), truth: Vec::new(), estimate: Vec::new() };
    cell.figures.insert(Quantity::Coverage, report.coverage);
    if let Some(error) = &error {
        cell.figures.insert(Quantity::AteM, error.statistics.rmse);
    }
    (cell.truth, cell.estimate) = camera_ways(&truth, &run, error.as_ref());
    Ok(cell)
}

/// The camera's way while there were images, and the aligned estimates.
fn camera_ways(truth: &CameraTrajectory, run: &SlamRun, error: Option<&AbsoluteError>) -> Ways {
    let records = &run.history.records;
    let (Some(first), Some(last)) = (records.first(), records.last()) else { return Ways::default() };
    let during = truth.poses().iter().filter(|pose| (first.at..=last.at).contains(&pose.at));
    let during = during.map(|pose| {
        let t = pose.world_from_camera.translation();
        (pose.at, Some([t.x, t.y, t.z]))
    });
    let pairs = associate(truth, &run.trajectory, POSE_TOLERANCE_SECS);
    let aligned = error.into_iter().flat_map(|error| {
        pairs.iter().map(|pair| {
            let p = error.similarity.place(pair.estimate.world_from_camera.translation());
            (pair.truth.at, [p.x, p.y, p.z])
        })
    });
    ways(&during.collect::<Vec<_>>(), &aligned.collect())
}
