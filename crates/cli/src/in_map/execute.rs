//! The run.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use visloc_core::{CameraPose, CameraTrajectory, Clock, SkippedInput, geom::Camera};
use visloc_io::{
    sequence::write_camera_trajectory,
    sources::{SourceOption, SourceOptions},
};
use visloc_slam::SlamConfig;
use visloc_vmap::{MapLocalizer, VisualMap};

use super::{
    diagnosis::MapCounters,
    frames::MapFrames,
    photo::finest_focal_px,
    report::{InMapReport, MapRecord, draw, is_metric, summarize, trajectory, write_estimates},
    watchers::Watchers,
};
use crate::{
    args::LocalizeArgs,
    host::host,
    report::{SkippedReport, diagnosis_lines, save_json},
    run::{Progress, Saving, prepare, source_options},
    say,
    settings::{OF_PIPELINE, SlamJob, slam_config_over, topic_options},
    slam::{MapView, MapWish, load_fixed_map},
    stopwatch::thread_cpu_secs,
    studio::Steering,
};

/// Finds a camera in a map of SLAM. The options of the source that outputs honor are given.
pub fn execute(args: &LocalizeArgs, honored_elsewhere: Vec<SourceOption>) -> Result<()> {
    refuse_others(args)?;
    let name = args.map.as_deref().unwrap_or_default();
    let config = slam_config_over(SlamConfig::default(), args.config.as_deref(), &args.set, SlamJob::Extend)?;
    let map = load_fixed_map(Path::new(name))?;
    let mut options = SourceOptions {
        seed: args.seed.given,
        num_threads: args.threads.given(),
        honored_elsewhere,
        range: args.range.range(),
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    options.usual.max_frames = args.frames.map(|frames| frames as usize);
    prepare(&args.source)?;
    // It stands when the run ends.
    let steering = Steering::of(&args.broadcast.drive, &args.source, &options)?;
    let (mut frames, truth, warnings) =
        MapFrames::open(&args.source, steering.as_ref(), &options, &args.corrections)?;
    warnings.iter().for_each(|warning| say::note!("{warning}"));
    let mut watchers = Watchers::open(args, steering.as_ref(), &options, (&config, &map), &frames)?;
    let run = run(args, (&map, truth.as_ref()), &config, &mut frames, &mut watchers)?;
    let told = (!run.truth.poses().is_empty()).then_some(&run.truth);
    let map = run.map.as_deref().unwrap_or(&map);
    finish(args, name, map, &run, truth.as_ref().or(told), watchers)
}

/// Focal lengths of one camera differ by less, as a share: calibrations are better than that.
const OTHER_LENS_SHARE: f64 = 0.05;

/// Says that a camera with images as large as those of the map has another lens: as a rule it is the same one, and a calibration is wrong.
fn note_other_lens(map: &VisualMap, camera: &Camera) {
    let cameras = map.map.all_keyframes().filter_map(|(_, keyframe)| keyframe.foreign.as_deref());
    let alike = cameras.map(|session| session.calibrated).filter(|known| known.size_px() == camera.size_px());
    let focal_px: Vec<f64> = alike.map(|known| known.focal_px().0).collect();
    let own_px = camera.focal_px().0;
    if let Some(first_px) = focal_px.first()
        && focal_px.iter().all(|known_px| (own_px / known_px).ln().abs() > OTHER_LENS_SHARE)
    {
        say::note!(
            "this camera has a focal length of {own_px:.1} px, the one of the map, with images of the same size, {first_px:.1} px; if it is \
             the same camera, one calibration is wrong and so are the places (--camera FILE)"
        );
    }
}

/// What came of the images.
struct Run {
    records: Vec<MapRecord>,
    /// The map that was loaded meanwhile.
    map: Option<Box<VisualMap>>,
    /// What stood in the way of places.
    counters: MapCounters,
    /// Where the camera really was, if the source said so with its images.
    truth: CameraTrajectory,
    skipped: Vec<SkippedInput>,
    broken: Option<String>,
}

fn run(
    args: &LocalizeArgs,
    (map, truth): (&VisualMap, Option<&CameraTrajectory>),
    config: &SlamConfig,
    frames: &mut MapFrames,
    watchers: &mut Watchers,
) -> Result<Run> {
    let progress = Progress::new(frames.status().num_items);
    let (mut config, mut seed) = (config.clone(), args.seed.value());
    let mut localizer: Option<MapLocalizer> = None;
    let mut finest_px = finest_focal_px(map);
    let mut run = Run {
        records: Vec::new(),
        map: None,
        counters: MapCounters::new(map),
        truth: CameraTrajectory::new(),
        skipped: Vec::new(),
        broken: None,
    };
    let most = args.frames.map_or(usize::MAX, |frames| frames as usize);
    while run.records.len() < most {
        let frame = match frames.next() {
            Some(Ok(next)) => next,
            Some(Err(broken)) => {
                run.broken = Some(broken.to_string());
                break;
            }
            None => break,
        };
        if let Some(wish) = watchers.take_wishes(&mut config, &mut seed) {
            localizer = None;
            if let MapWish::In(other) = wish {
                finest_px = finest_focal_px(&other);
                run.map = Some(other);
            }
        }
        let map = run.map.as_deref().unwrap_or(map);
        let calibrated = frame.camera;
        let frame = frame.no_finer_than(finest_px);
        let localizer = match &mut localizer {
            Some(localizer) => localizer,
            none => {
                note_other_lens(map, &calibrated);
                let made = none.insert(MapLocalizer::in_map(map, &frame.camera, &config, seed)?);
                made.set_clock(Clock::new(thread_cpu_secs));
                made
            }
        };
        let started = thread_cpu_secs();
        let at = frame.gray.at;
        if let Some(world_from_camera) = frame.gray.truth {
            let _ = run.truth.push(CameraPose { at, world_from_camera });
        }
        match localizer.step(frame.gray.clone()) {
            Ok(estimate) => {
                let secs = thread_cpu_secs() - started;
                run.records.push(MapRecord { at, estimate, secs });
                run.counters.count(&frame, localizer, &config);
                let num_dropped = frames.status().num_dropped;
                watchers.look(&MapView { map, truth, localizer, frame: &frame, num_dropped });
            }
            Err(reason) => run.skipped.push(SkippedInput {
                at: Some(at),
                origin: "images".to_owned(),
                reason: reason.to_string(),
            }),
        }
        progress.advance();
    }
    progress.clear();
    run.skipped.extend(frames.status().skipped.iter().cloned());
    Ok(run)
}

fn finish(
    args: &LocalizeArgs,
    name: &str,
    map: &VisualMap,
    run: &Run,
    truth: Option<&CameraTrajectory>,
    watchers: Watchers,
) -> Result<()> {
    let skipped = SkippedReport::new(run.skipped.iter());
    let mut report = summarize((&args.source, name), map, &run.records, truth, skipped, run.broken.clone());
    report.diagnosis = run.counters.explain();
    print(&report, map, truth.is_some());
    watchers.print();
    let mut saving = Saving::default();
    watchers.finish(&mut saving);
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.save_if(args.trajectory.as_deref(), |path| {
        Ok(write_camera_trajectory(path, &trajectory(&run.records), is_metric(map))?)
    });
    saving.save_if(args.estimates.as_deref(), |path| write_estimates(path, &run.records));
    saving.save_if(args.plots.as_deref(), |folder| {
        draw(folder, &args.source, map, &run.records)?;
        say::line!("pictures: {}", folder.display());
        Ok(())
    });
    saving.save_if(run.broken.as_ref(), |broken| {
        bail!("{broken}{}", say::before(run.records.len(), "frame", "done"))
    });
    if run.records.is_empty() && run.broken.is_none() && !host().is_stopped() {
        saving.save(Err(anyhow!("{}: no frame that can be used", args.source)));
    }
    saving.end()
}

fn print(report: &InMapReport, map: &VisualMap, has_truth: bool) {
    say::line!("{}: {} in {}", report.source, say::count(report.frames, "frame"), report.map);
    say::line!(
        "  localized in {:.1} % (carried on in {:.1} % by what was seen since, in {:.1} % by odometry), found from nothing {}",
        report.localized * 100.0,
        report.carried_by_motion * 100.0,
        report.carried_by_odometry * 100.0,
        say::count(report.found, "time")
    );
    if let Some(secs) = report.first_after_s {
        say::line!("  for the first time after {secs:.1} s");
    }
    if let (Some(median), Some(max)) = (report.median_ms, report.max_ms) {
        say::line!("  {median:.1} ms an image, {max:.1} at most");
    }
    match &report.error {
        Some(error) => say::line!(
            "  position error {:.4} m median, {:.4} m p95, {:.4} m at most; orientation {:.3} deg median",
            error.median_m,
            error.p95_m,
            error.max_m,
            error.median_deg
        ),
        None if has_truth => {
            say::line!("  the truth has another frame than the map: visloc map align gives it the same");
        }
        None => {}
    }
    if let Some(error) = &report.carried_error {
        say::line!("  where it was carried on: {:.4} m median, {:.4} m at most", error.median_m, error.max_m);
    }
    if let Some(largest) = map.largest() {
        let scale = map.scale(largest);
        say::line!("  lengths in {}; scale: {}", report.unit, scale.source.name());
    }
    for line in diagnosis_lines("localized", &report.diagnosis).into_iter().chain(report.skipped.lines()) {
        say::line!("{line}");
    }
}

/// Options that make no difference in a map of SLAM.
fn refuse_others(args: &LocalizeArgs) -> Result<()> {
    let of_pipeline = args.set.iter().find(|option| option.trim_start().starts_with(OF_PIPELINE));
    let others = [
        ("--pipeline", args.pipeline.is_some()),
        (of_pipeline.map_or("", String::as_str), of_pipeline.is_some()),
        ("--visual-odometry", args.visual_odometry),
        ("--features", args.features.is_some()),
        ("--start", !args.start.is_empty()),
        ("--robot-out", args.robot_out.is_some()),
        ("--team", args.team.is_some()),
        ("--picture-at", args.picture_at.is_some()),
        ("--algorithm", args.algorithm != "evolutionary"),
    ];
    match others.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => bail!("{option}: it makes no difference in a map of SLAM (.vmap)"),
        None => Ok(()),
    }
}
