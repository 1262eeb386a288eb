//! `visloc calibrate-robot`: mounting and odometry from a drive on a known map.

use anyhow::{Context, Result, bail};
use serde::Serialize;
use visloc_io::sources::{SourceOption, SourceOptions};
use visloc_locate::{
    Half, StartPrior, feature_model,
    robot_calibration::{
        DriveRecord, MountEstimate, OdometryEstimate, RobotCorrection, solve_mount, solve_odometry,
    },
};
use visloc_world::Map;

use crate::{
    args::{CalibrateRobotArgs, StartArg},
    host::host,
    report::{diagnosis_lines, explain_localization, save_json},
    run::{
        FrameView, Progress, Runner, RunnerSettings, Saving, Spectator, drive, of_one_camera, open_source,
        prepare, read_correction, source_options, with_correction, write_correction,
    },
    say,
    settings::{pipeline_config, start_prior, topic_options},
};

/// The algorithm that finds the places; the tracks make poses of them.
const ALGORITHM: &str = "evolutionary";
/// Passes end when pitch and roll change by less, degrees.
const SETTLED_DEG: f64 = 0.02;

/// What is written with `--json`.
#[derive(Serialize)]
struct RobotReport {
    correction: RobotCorrection,
    /// Pitch, roll (degrees), height (meters).
    camera_standard_deviations: [f64; 3],
    /// Three factors, drift (degrees per meter).
    odometry_standard_deviations: [f64; 4],
    rms_px_before: f64,
    rms_px_after: f64,
    num_views: usize,
    num_stretches: usize,
    passes: usize,
}

/// Keeps what the localizer saw.
#[derive(Default)]
struct Collector {
    record: DriveRecord,
}

impl Spectator for Collector {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        let Some(runner) = view.runners.first() else { return };
        let Some(record) = runner.records().latest().filter(|record| record.at == view.frame.at) else {
            return;
        };
        let pose = record.is_localized().then_some(record.world_from_robot);
        self.record.add(runner.pipeline().analyzer().percept(), pose, view.frame.odometry);
    }
}

/// Runs the command.
pub fn execute(args: &CalibrateRobotArgs) -> Result<()> {
    prepare(&args.source)?;
    let mut correction = read_correction(&args.corrections)?;
    // The camera is corrected for each pass; the odometry is always seen as it was reported.
    correction.odometry = Default::default();
    let mut passes = 0;
    let (mut first_rms_px, mut result): (Option<f64>, Option<(MountEstimate, OdometryEstimate)>) =
        (None, None);
    while passes < args.passes as usize {
        let (map, record) = one_pass(args, &correction)?;
        let mut model = feature_model(&map, &pipeline_config(None, &[])?)?;
        let mount = solve_mount(&record, model.as_mut()).with_context(|| args.source.to_string())?;
        let odometry = solve_odometry(&record).with_context(|| args.source.to_string())?;
        passes += 1;
        correction.camera.pitch_down_deg += mount.correction.pitch_down_deg;
        correction.camera.roll_clockwise_deg += mount.correction.roll_clockwise_deg;
        correction.camera.height_m += mount.correction.height_m;
        first_rms_px.get_or_insert(mount.rms_px.0);
        result = Some((mount, odometry));
        let change = mount.correction.pitch_down_deg.abs().max(mount.correction.roll_clockwise_deg.abs());
        if change < SETTLED_DEG || host().is_stopped() {
            break;
        }
    }
    let Some((mount, odometry)) = result else { bail!("no pass over {}", args.source) };
    correction.odometry = odometry.correction;
    let report = RobotReport {
        correction,
        camera_standard_deviations: mount.standard_deviations,
        odometry_standard_deviations: odometry.standard_deviations,
        rms_px_before: first_rms_px.unwrap_or(mount.rms_px.0),
        rms_px_after: mount.rms_px.1,
        num_views: mount.num_views,
        num_stretches: odometry.num_stretches,
        passes,
    };
    print(args, &report);
    write(args, &report)
}

/// Localizes once with the corrections so far.
fn one_pass(args: &CalibrateRobotArgs, correction: &RobotCorrection) -> Result<(Map, DriveRecord)> {
    let mut options = SourceOptions {
        seed: args.seed.given,
        num_threads: args.threads.given(),
        // The algorithm takes it too.
        honored_elsewhere: vec![SourceOption::Seed],
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    options.usual.max_frames = args.frames.map(|frames| frames as usize);
    let source = open_source(&args.source, args.map.as_deref(), &options)?;
    let mut frames = with_correction(of_one_camera(source.frames, &args.source), *correction);
    let settings = RunnerSettings {
        algorithm: ALGORITHM,
        algorithm_toml: None,
        pipeline: pipeline_config(None, &[])?,
        start: start_on(&source.map)?,
        seed: args.seed.value(),
    };
    let mut runners = [Runner::new(&source.map, &settings)?];
    let mut progress = Progress::new(frames.status().num_items);
    let mut collector = Collector::default();
    let outcome = drive(frames.as_mut(), args.frames, &mut runners, &mut [&mut progress, &mut collector]);
    progress.clear();
    let [runner] = runners;
    if !host().was_interrupted() {
        for line in diagnosis_lines(
            "localized",
            &explain_localization(&runner.counters().diagnosis(), runner.start()),
        ) {
            say::line!("{line}");
        }
    }
    if let Some(error) = outcome.error {
        say::note!("{error}{}", say::before(outcome.num_frames, "frame", "used"));
    }
    Ok((source.map, collector.record))
}

/// Where the robot may start. On a field that looks the same from both sides it is said to be in one half: if it is in the other one, all its
/// places are mirrored, which changes nothing of what is found.
fn start_on(map: &Map) -> Result<StartPrior> {
    let is_mirrored = matches!(map, Map::Field(field) if field.is_point_symmetric());
    start_prior(if is_mirrored { &[StartArg::Half(Half::Negative)] } else { &[] }, map)
}

fn print(args: &CalibrateRobotArgs, report: &RobotReport) {
    let RobotCorrection { camera, odometry } = &report.correction;
    let (c, o) = (&report.camera_standard_deviations, &report.odometry_standard_deviations);
    say::line!(
        "{}: {} views, {} stretches of motion, {} passes",
        args.source,
        report.num_views,
        report.num_stretches,
        report.passes
    );
    say::line!();
    say::line!("  camera looks farther down by  {:7.2} +- {:.2} deg", camera.pitch_down_deg, c[0]);
    say::line!("  camera is rolled clockwise by {:7.2} +- {:.2} deg", camera.roll_clockwise_deg, c[1]);
    say::line!("  camera is higher by           {:7.3} +- {:.3} m", camera.height_m, c[2]);
    for (i, what) in ["ahead", "to the side", "turning"].into_iter().enumerate() {
        say::line!("  odometry, factor {what:<12} {:7.3} +- {:.3}", odometry.scale[i], o[i]);
    }
    say::line!("  odometry, turn to the left    {:7.2} +- {:.2} deg/m", odometry.drift_deg_per_m, o[3]);
    say::line!();
    say::line!(
        "border pixels lie {:.2} px from the map before and {:.2} px after the correction (RMS)",
        report.rms_px_before,
        report.rms_px_after
    );
}

fn write(args: &CalibrateRobotArgs, report: &RobotReport) -> Result<()> {
    let mut saving = Saving::default();
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, report));
    saving.save_if(args.out.as_deref(), |path| {
        write_correction(path, &report.correction, "visloc calibrate-robot")
    });
    saving.end()
}
