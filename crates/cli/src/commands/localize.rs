//! `visloc localize`: find the robot in a recording.

use std::path::Path;

use anyhow::{Result, anyhow};
use visloc_core::{Mapped, Source, SourceFrame};
use visloc_io::sources::{SourceAddress, SourceOption, SourceOptions};
use visloc_locate::{CameraMisalignment, ConfigError, PipelineConfig, robot_calibration::RobotCorrection};
use visloc_slam::ground::GroundOdometer;
use visloc_world::Map;

use crate::{
    args::LocalizeArgs,
    host::host,
    in_map,
    report::{
        AlgorithmReport, CameraOfRobot, Column, Curve, LocalizeReport, RunPictures, SkippedReport,
        SnapshotTaker, comparison_table, diagnosis_lines, measure, percent, save_json,
    },
    run::{
        BagOutput, FrameRecord, LiveReport, OpenSource, OutputFiles, Progress, Records, RunOutcome, Runner,
        RunnerSettings, Saving, Spectator, StartCheck, corrected, drive, open_live, open_source, prepare,
        read_correction, source_options, write_correction,
    },
    say,
    settings::{
        OF_PIPELINE, algorithm_toml, pipeline_config, refuse_without_effect, start_prior, swapped,
        topic_options,
    },
    stopwatch::{peak_memory_mb, process_cpu_secs},
    studio::{Steering, open_show},
};

/// Runs the command.
pub fn execute(args: &LocalizeArgs) -> Result<()> {
    if in_map::is_wanted(args) {
        return in_map::execute(args, honored_by_outputs(args));
    }
    let pipeline = pipeline_of(args).map_err(|error| swapped_in(args).unwrap_or(error))?;
    let algorithm_toml = algorithm_toml(args.config.as_deref(), &args.set)?;
    let mut options = SourceOptions {
        seed: args.seed.given,
        num_threads: args.threads.given(),
        honored_elsewhere: honored_by_outputs(args),
        range: args.range.range(),
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    options.usual.max_frames = args.frames.map(|frames| frames as usize);
    prepare(&args.source)?;
    let steering = Steering::of(&args.broadcast.drive, &args.source, &options)?;
    let source = open(args, steering.as_ref(), &options)?;
    source.warnings.iter().for_each(|warning| say::note!("{warning}"));
    refuse_without_effect(&args.set, &source.map, pipeline.features)?;
    let settings = RunnerSettings {
        algorithm: &args.algorithm,
        algorithm_toml: algorithm_toml.as_deref(),
        pipeline,
        start: start_prior(&args.start, &source.map)?,
        seed: args.seed.value(),
    };
    // Outputs begin when nothing stands in their way any more: a wrong parameter, or a signal while a large map is prepared.
    let runner = runner_of(args, &source.map, &settings)?;
    let is_asked_for = args.plots.is_some() || args.json.json.is_some();
    let is_live = SourceAddress::parse(&args.source)?.kind().is_live || steering.is_some();
    let most_records = Records::<FrameRecord>::most_of(is_live, is_asked_for);
    let mut live = live_output(args, &options, &source.map)?;
    let mut progress = Progress::new(source.frames.status().num_items);
    let mut show = open_show(args, steering.as_ref())?;
    let mut bag_out =
        args.bag_out.as_deref().map(|path| BagOutput::create(path, &options.topics.names())).transpose()?;
    let files = OutputFiles::create(args.trajectory.as_deref(), args.estimates.as_deref())?;
    let mut runners = [runner.writing(files).keeping(most_records)];
    let mut snapshots = SnapshotTaker::new(args.picture_at);
    let mut start = StartCheck::new(&settings.start, &source.map, settings.pipeline.lift);
    let mut spectators: Vec<&mut dyn Spectator> = Vec::new();
    // First, so that a pose waits for nothing.
    spectators.extend(live.as_deref_mut().map(|live| live as &mut dyn Spectator));
    spectators.extend([&mut progress as &mut dyn Spectator, &mut start]);
    spectators.extend(bag_out.as_mut().map(|bag| bag as &mut dyn Spectator));
    if args.plots.is_some() {
        spectators.push(&mut snapshots);
    }
    spectators.extend(show.as_deref_mut().map(|show| show as &mut dyn Spectator));
    let robot = read_correction(&args.corrections)?;
    let mut frames = as_asked_for(source.frames, args)?;
    let outcome = drive(frames.as_mut(), args.frames, &mut runners, &mut spectators);
    progress.clear();
    let [mut runner] = runners;
    // Numbers first, pictures last.
    let mut saving = Saving::default();
    saving.save(runner.finish());
    let live = live.and_then(|live| live.report());
    let report = summarize(args, &source.map, &runner, &outcome, live);
    print(&report, &runner, &start);
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.save_if(args.robot_out.as_deref(), |path| save_robot(path, robot, report.camera_error.as_ref()));
    saving.save_if(bag_out, BagOutput::finish);
    saving.save_if(show, Spectator::finish);
    saving.save_if(args.plots.as_deref(), |folder| {
        draw(folder, &source.map, &report, &runner, &outcome)?;
        if let Some(snapshot) = snapshots.snapshot() {
            snapshot.draw().save(folder, "analysis")?;
        }
        if let Some(at_secs) = args.picture_at.filter(|at_secs| *at_secs > outcome.duration_secs) {
            say::note!(
                "--picture-at {at_secs}: the images end after {:.1} s; analysis.png shows the last one",
                outcome.duration_secs
            );
        }
        say::line!("pictures: {}", folder.display());
        Ok(())
    });
    saving.save(verdict(args, &outcome));
    saving.end()
}

/// A simulated robot goes where others drive it, if they may.
fn open(args: &LocalizeArgs, steering: Option<&Steering>, options: &SourceOptions) -> Result<OpenSource> {
    let name = args.map.as_deref();
    let driven = steering.map(|steering| steering.simulated(&args.source, options)).transpose()?.flatten();
    let Some(driven) = driven else { return open_source(&args.source, name, options) };
    Ok(OpenSource { map: name.map(Map::load).transpose()?.unwrap_or(driven.map), ..driven })
}

/// The frames with what the options say of the robot.
fn as_asked_for(
    frames: Box<dyn Source<SourceFrame>>,
    args: &LocalizeArgs,
) -> Result<Box<dyn Source<SourceFrame>>> {
    let frames = corrected(frames, &args.corrections)?;
    if !args.visual_odometry {
        return Ok(frames);
    }
    let mut odometer = GroundOdometer::new();
    Ok(Box::new(Mapped::new(frames, move |mut source: SourceFrame| {
        source.frame.odometry = odometer.step(&source.frame);
        Ok(source)
    })))
}

/// Keeps the corrections for the next run, with what this one has shown of the camera. Its turn about the vertical is the heading's.
fn save_robot(path: &Path, mut robot: RobotCorrection, error: Option<&CameraMisalignment>) -> Result<()> {
    match error.filter(|error| error.is_confirmed) {
        Some(error) => {
            robot.camera.pitch_down_deg += error.pitch_down_deg.mean;
            robot.camera.roll_clockwise_deg += error.roll_clockwise_deg.mean;
        }
        None => say::note!("{}: nothing has shown an error of the camera", path.display()),
    }
    write_correction(path, &robot, "visloc localize")
}

/// Whether the source was read to its end.
fn verdict(args: &LocalizeArgs, outcome: &RunOutcome) -> Result<()> {
    match &outcome.error {
        Some(error) => Err(anyhow!("{error}{}", say::before(outcome.num_frames, "frame", "done"))),
        None if outcome.num_frames == 0 && !host().is_stopped() => {
            Err(anyhow!("{}: no frame that can be used", args.source))
        }
        None => Ok(()),
    }
}

/// The parameters of everything but the algorithm.
fn pipeline_of(args: &LocalizeArgs) -> Result<PipelineConfig> {
    let mut pipeline = pipeline_config(args.pipeline.as_deref(), &args.set)?;
    if let Some(features) = args.features {
        pipeline.features = features;
    }
    pipeline.analysis.detect_objects |= args.team.is_some();
    Ok(pipeline)
}

/// An algorithm with its parameters. Beside single options the lines of a file are not those of its text any more.
fn runner_of(args: &LocalizeArgs, map: &Map, settings: &RunnerSettings<'_>) -> Result<Runner> {
    let is_text = args.set.iter().all(|option| option.trim_start().starts_with(OF_PIPELINE));
    let runner = Runner::new(map, settings).map_err(|error| match error.downcast::<ConfigError>() {
        Ok(error) if !is_text => error.without_line().into(),
        Ok(error) => error.into(),
        Err(error) => error,
    });
    runner.map_err(|error| swapped_in(args).unwrap_or_else(|| error.context(config_place(args))))
}

/// Whether parameters of the algorithm and of the pipeline were given for each other.
fn swapped_in(args: &LocalizeArgs) -> Option<anyhow::Error> {
    swapped(&args.algorithm, (args.config.as_deref(), args.pipeline.as_deref()), &args.set)
}

/// Where a wrong parameter stands.
fn config_place(args: &LocalizeArgs) -> String {
    let files = [&args.config, &args.pipeline].into_iter().flatten();
    let mut names: Vec<String> = files.map(|path| path.display().to_string()).collect();
    names.extend(args.set.iter().map(|option| format!("--set {option}")));
    if names.is_empty() { "cannot start".to_owned() } else { names.join(", ") }
}

/// Options of the source that make a difference to the algorithm or to what is written, whatever the source is.
fn honored_by_outputs(args: &LocalizeArgs) -> Vec<SourceOption> {
    let mut honored = vec![SourceOption::Seed];
    if args.publish_ros || args.publish_map || args.team.is_some() {
        honored.extend([SourceOption::RosDomain, SourceOption::BaseFrame]);
    }
    if args.bag_out.is_some() {
        honored.extend(SourceOption::TOPICS);
    }
    honored
}

/// Live topics, if they are asked for or the source is one itself.
fn live_output(
    args: &LocalizeArgs,
    options: &SourceOptions,
    map: &Map,
) -> Result<Option<Box<dyn Spectator>>> {
    let is_live = args.source.starts_with("ros2:");
    let is_asked_for = args.publish_ros || args.publish_map || args.team.is_some();
    let is_wanted = is_asked_for || (is_live && !args.no_publish_ros);
    let floor = match args.publish_map {
        true => {
            Some(map.occupancy_grid().ok_or_else(|| anyhow!("--publish-map: the map is longer than 400 m"))?)
        }
        false => None,
    };
    is_wanted.then(|| open_live(args, options, map, floor.as_ref())).transpose()
}

fn summarize(
    args: &LocalizeArgs,
    map: &Map,
    runner: &Runner,
    outcome: &RunOutcome,
    live: Option<LiveReport>,
) -> LocalizeReport {
    let frames_per_s = outcome.num_frames as f64 / outcome.wall_secs.max(1e-9);
    LocalizeReport {
        source: args.source.to_string(),
        map: map.name().to_owned(),
        seed: args.seed.value(),
        algorithm: AlgorithmReport::new(runner, outcome),
        duration_s: outcome.duration_secs,
        frames_per_s,
        peak_memory_mb: peak_memory_mb(),
        process_cpu_s: process_cpu_secs(),
        dropped: outcome.num_dropped,
        live,
        camera_error: runner.pipeline().localizer().camera_error(),
        cameras: CameraOfRobot::all(runner),
        skipped: SkippedReport::new(outcome.skipped.iter().chain(runner.rejected())),
        error: outcome.error.as_ref().map(ToString::to_string),
    }
}

fn print(report: &LocalizeReport, runner: &Runner, start: &StartCheck) {
    say::line!(
        "{}: {}, {:.1} s, at {:.0} frames a second",
        report.source,
        say::count(report.algorithm.evaluation.frames, "frame"),
        report.duration_s,
        report.frames_per_s
    );
    if report.algorithm.evaluation.frames > 0 {
        print_algorithm(report, runner);
    }
    if let Some(share) = runner.counters().odometry_jumps() {
        say::line!(
            "the odometry jumps in {} of the images, farther than a robot moves, and is not believed there: are its lengths meters?",
            percent(Some(share))
        );
    }
    start.line().iter().for_each(|line| say::line!("{line}"));
    print_cameras(&report.cameras);
    print_live(report);
    for line in report.skipped.lines_beside(report.error.as_deref()) {
        say::line!("{line}");
    }
}

fn print_algorithm(report: &LocalizeReport, runner: &Runner) {
    say::line!();
    let column = Column { title: &report.algorithm.algorithm, report: &report.algorithm.evaluation };
    say::text(format_args!("{}", comparison_table(&[column])));
    if report.algorithm.comparison.is_none() && !runner.records().is_empty() {
        print_without_truth(runner.records());
    }
    say::line!();
    for line in diagnosis_lines("localized", &report.algorithm.diagnosis) {
        say::line!("{line}");
    }
}

/// What was found out about the cameras; of several, also how many images came of each.
fn print_cameras(cameras: &[CameraOfRobot]) {
    for CameraOfRobot { camera, images, camera_error } in cameras {
        let name = if cameras.len() == 1 { "the camera".to_owned() } else { format!("camera {camera}") };
        if cameras.len() > 1 {
            say::line!("{name}: {}", say::count(*images, "image"));
        }
        let Some(error) = camera_error.as_ref().filter(|error| error.is_confirmed) else { continue };
        let (pitch, roll) = (&error.pitch_down_deg, &error.roll_clockwise_deg);
        say::line!(
            "{name} looks {:.2} +- {:.2} deg farther down than reported and is rolled by {:.2} +- {:.2} deg clockwise",
            pitch.mean,
            pitch.sigma,
            roll.mean,
            roll.sigma
        );
    }
}

fn print_live(report: &LocalizeReport) {
    if report.dropped > 0 {
        say::line!("dropped while others were worked on: {}", say::count(report.dropped, "image"));
    }
    let Some(live) = &report.live else { return };
    if let (Some(delay), Some(overhead)) = (live.delay_ms.median, live.overhead_ms.median) {
        say::line!(
            "from an image to its pose {delay:.2} ms, {overhead:.2} of it beside the algorithm (median of published ones)"
        );
    }
    if live.unsent > 0 {
        say::line!("{} messages could not be sent: a subscriber is too slow", live.unsent);
    }
    #[cfg(feature = "ros2")]
    if let Some(team) = &live.team {
        say::line!(
            "team: {}, {} sent ({:.0} bytes a second) and {} heard, {} of them refused; {:.3} ms an image (median)",
            say::count(team.robots, "other robot"),
            say::count(team.sent, "message"),
            team.bytes_per_s,
            team.heard,
            team.refused,
            team.ms.median.unwrap_or_default()
        );
        for number in &team.numbers_twice {
            say::line!("team: two robots have the number {number}; give each its own with --number");
        }
    }
}

/// Without a truth there is only what the algorithm says of itself.
fn print_without_truth(records: &[FrameRecord]) {
    let localized: Vec<_> = records.iter().filter(|record| record.is_localized()).collect();
    let share = (!records.is_empty()).then(|| localized.len() as f64 / records.len() as f64);
    say::line!();
    say::line!(
        "The source has no truth to compare with. The algorithm says that it knew the place in {} of the frames",
        percent(share)
    );
    if let (Some(start), Some(first), Some(last)) = (records.first(), localized.first(), localized.last()) {
        let pose = last.world_from_robot;
        say::line!(
            "for the first time after {:.1} s; at the end at x {:.2} m, y {:.2} m, heading {:.0} deg.",
            first.at.secs_since(start.at),
            pose.x_m,
            pose.y_m,
            pose.yaw_rad.to_degrees()
        );
    }
}

fn draw(
    folder: &Path,
    map: &Map,
    report: &LocalizeReport,
    runner: &Runner,
    outcome: &RunOutcome,
) -> Result<()> {
    let pictures = RunPictures {
        title: report.source.clone(),
        subtitle: subtitle(report),
        map: Some(map),
        truth: &outcome.truth,
        curves: vec![Curve {
            label: runner.name(),
            samples: runner.records().iter().map(FrameRecord::sample).collect(),
            comparison: report.algorithm.comparison.as_ref(),
            individuals: runner.records().iter().map(|record| (record.at, record.num_individuals)).collect(),
        }],
    };
    pictures.save(folder)?;
    Ok(())
}

fn subtitle(report: &LocalizeReport) -> String {
    let LocalizeReport { algorithm, map, .. } = report;
    let frames = say::count(algorithm.evaluation.frames, "frame");
    let frames = format!("{}, {frames} on {map}", algorithm.algorithm);
    let error_m = algorithm.evaluation.position_error_m.filter(|error_m| error_m.mean.is_some());
    let Some(error_m) = error_m else { return frames };
    let [mean, median] = [error_m.mean, error_m.median].map(|value| measure(value, " m", 2));
    format!("{frames}; position error {mean} mean, {median} median")
}
