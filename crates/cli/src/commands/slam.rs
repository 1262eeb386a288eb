//! `visloc slam`: follow a camera without a map.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use visloc_core::{CameraPose, CameraTrajectory};
use visloc_io::{
    sequence::write_camera_trajectory,
    sources::{OpenImages, SourceAddress},
};
use visloc_slam::Schedule;
use visloc_vmap::VisualMap;
use visloc_world::BUILT_IN_MAPS;

use crate::{
    args::SlamArgs,
    report::{diagnosis_lines, save_json},
    run::{Records, Saving, source_options},
    say,
    settings::{SlamJob, slam_config, topic_options},
    slam::{
        FramePictures, Lookers, RunOptions, SlamAudience, SlamRecord, SlamReport, SlamRun, SlamWatcher, draw,
        load_map, map_given_poses, open_input, open_slam_live, run, save_map, write_log, write_ply,
    },
    studio::{Steering, open_slam_show},
};

/// Frames between pictures of single frames.
const PICTURE_EVERY: usize = 50;

/// Runs the command.
pub fn execute(args: &SlamArgs) -> Result<()> {
    if let Some(points) = &args.points {
        refuse_name_of_map(points)?;
    }
    let config = slam_config(&args.parameters, job(args))?;
    let loaded = args.load.as_deref().map(load_map).transpose()?;
    let mut steering = None;
    let OpenImages { images: mut source, truth, warnings } = open_input(args, |options| {
        steering = Steering::of(&args.broadcast.drive, &args.source, options)?;
        let driven = steering.as_ref().map(|steering| steering.simulated(&args.source, options));
        Ok(driven.transpose()?.flatten())
    })?;
    warnings.iter().for_each(|warning| say::note!("{warning}"));
    if let (Some(poses), Some(out)) = (args.poses.as_deref(), args.save.as_deref()) {
        return map_given_poses(args, &config, source.as_mut(), (poses, out));
    }
    let mut pictures = args.plots.as_deref().map(|folder| FramePictures::new(folder, PICTURE_EVERY));
    let mut live = live_output(args, loaded.as_ref())?;
    let mut show = open_slam_show(args, steering.as_ref(), &config, source.camera(), truth.as_ref())?;
    let lookers = Lookers {
        pictures: pictures.as_mut(),
        watcher: live.as_deref_mut().map(|live| live as &mut dyn SlamWatcher),
        show: show.as_deref_mut().map(|show| show as &mut dyn SlamAudience),
    };
    let options = RunOptions {
        maps: loaded.as_ref().map(|loaded| &loaded.map),
        is_fixed: args.fixed,
        ..run_options(args, steering.is_some())?
    };
    let run = run(source.as_mut(), &config, options, lookers)?;
    let (loaded, told) = live.map_or((loaded, None), SlamWatcher::finish);
    let truth = truth.or_else(|| run.truth.clone());
    let (report, error) = SlamReport::new(&run, truth.as_ref());
    print(args, &run, &report);
    // Numbers first, pictures last.
    let mut saving = Saving::default();
    saving.write("numbers", args.json.json.as_deref(), |path| save_json(path, &report));
    let is_metric = run.maps.first().is_some_and(|way| way.scale.is_some())
        || loaded.as_ref().is_some_and(crate::in_map::is_metric);
    write_files(args, &run, is_metric, &mut saving);
    saving.save_if(args.save.as_deref(), |path| save_map(path, args, &run, (loaded, told)));
    saving.save_if(show, SlamAudience::finish);
    saving.save_if(args.plots.as_deref(), |folder| {
        draw(folder, &args.source, &run, truth.as_ref(), error.as_ref())?;
        say::line!("pictures: {}", folder.display());
        Ok(())
    });
    saving.save_if(pictures, FramePictures::finish);
    let is_empty = run.num_images == 0 && run.error.is_none();
    saving.save_if(run.error, |error| {
        bail!("{error}{}", say::before(run.history.records.num_seen(), "frame", "done"))
    });
    if is_empty {
        saving.save(Err(anyhow!("{}: no image came", args.source)));
    }
    saving.end()
}

fn job(args: &SlamArgs) -> SlamJob {
    match (&args.poses, args.fixed) {
        (Some(_), _) => SlamJob::MapGivenPoses,
        (None, true) => SlamJob::Locate,
        (None, false) => SlamJob::Map,
    }
}

/// Points have another form than maps: who names a map means something else.
fn refuse_name_of_map(points: &Path) -> Result<()> {
    let is_built_in = BUILT_IN_MAPS.iter().any(|(name, _)| points.as_os_str() == *name);
    let ending = points.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if is_built_in || ["vmap", "toml", "yaml", "svg", "dxf"].contains(&ending) {
        bail!(
            "--points {0}: expected a name such as FILE.ply, for that is what is written; slam begins without a map: one of slam is kept \
             with --save and gone on in with --load, and in a known map the camera is found by visloc localize --map {0}",
            points.display()
        );
    }
    Ok(())
}

/// Live topics, if they are asked for or the source is one itself.
fn live_output(args: &SlamArgs, loaded: Option<&VisualMap>) -> Result<Option<Box<dyn SlamWatcher>>> {
    let is_live = args.source.starts_with("ros2:");
    if !(args.publish_ros || (is_live && !args.no_publish_ros)) {
        return Ok(None);
    }
    let options = source_options(&args.options, topic_options(&args.topics)?)?;
    Ok(Some(open_slam_live(options.domain_id(), args, loaded)?))
}

fn run_options(args: &SlamArgs, is_driven: bool) -> Result<RunOptions<'static>> {
    // A live source does not wait for the mapping, nor does who drives.
    let is_live = is_driven || SourceAddress::parse(&args.source)?.kind().is_live;
    let schedule = match args.schedule {
        Some(schedule) => schedule,
        None if is_live => Schedule::Threaded,
        None => Schedule::Sequential,
    };
    let is_realtime = args.realtime || (args.broadcast.publish.is_some() && !is_live);
    let is_asked_for =
        args.trajectory.is_some() || args.log.is_some() || args.plots.is_some() || args.json.json.is_some();
    let most_records = Records::<SlamRecord>::most_of(is_live, is_asked_for);
    Ok(RunOptions { seed: args.seed.value(), schedule, is_realtime, most_records, ..RunOptions::default() })
}

fn write_files(args: &SlamArgs, run: &SlamRun, is_metric: bool, saving: &mut Saving) {
    saving.write("trajectory", args.trajectory.as_deref(), |path| {
        Ok(write_camera_trajectory(path, run.trajectory.poses(), is_metric)?)
    });
    saving.write("keyframes", args.keyframes.as_deref(), |path| {
        let map = &run.map;
        let pose = |(_, k): (_, &visloc_slam::map::Keyframe)| CameraPose {
            at: k.at,
            world_from_camera: k.camera_from_world().inverse(),
        };
        let mut keyframes = CameraTrajectory::new();
        for pose in map.keyframes().map(pose) {
            let _ = keyframes.push(pose);
        }
        Ok(write_camera_trajectory(path, keyframes.poses(), is_metric)?)
    });
    saving.write("landmarks", args.points.as_deref(), |path| {
        write_ply(path, &run.map, run.slam.camera(), if is_metric { "m" } else { "map units" })
    });
    saving.write("log", args.log.as_deref(), |path| write_log(path, &run.history.records));
}

/// Loops, and each map if there are several.
fn print_maps(report: &SlamReport) {
    if report.loops + report.joins > 0 {
        say::line!(
            "  closed {}, joined maps {}",
            say::count(report.loops, "loop"),
            say::count(report.joins, "time")
        );
    }
    if report.maps.len() > 1 {
        for map in &report.maps {
            let error = map.ate_rmse_m.map(|rmse| format!(", ATE RMSE {rmse:.4} m")).unwrap_or_default();
            say::line!("  map {}: {}{error}", map.map, say::count(map.poses, "pose"));
        }
    }
}

fn print(args: &SlamArgs, run: &SlamRun, report: &SlamReport) {
    say::line!("{}: {}", args.source, say::count(report.frames, "frame"));
    say::line!(
        "  tracked {:.1} %, lost {}, found again {}; {}, {}",
        report.coverage * 100.0,
        say::count(report.lost_spells, "time"),
        say::count(report.relocalizations, "time"),
        say::count(report.keyframes, "keyframe"),
        say::count(report.points, "landmark")
    );
    if report.carried > 0 {
        say::line!("  {} more images told too little: odometry carried the pose on", report.carried);
    }
    if let Some(scale) = report.maps.first().and_then(|map| map.scale.as_ref()) {
        say::line!(
            "  lengths are meters: by {0} over {1:.1} m of way, +-{2:.1} % of what the {0} says; its own error comes on top",
            scale.source,
            scale.way_m,
            scale.deviation * 100.0
        );
    }
    print_maps(report);
    if report.dropped + report.unmapped > 0 {
        say::line!(
            "  {} dropped while tracking was busy, {} not mapped while mapping was",
            say::count(report.dropped, "image"),
            report.unmapped
        );
    }
    if report.lens_change != 0.0 {
        say::line!(
            "  the lens is not as calibrated: {:+.4} on the first radial coefficient make the views agree",
            report.lens_change
        );
    }
    let [across, down] = report.readout_s.map(|secs| secs.abs() * 1e3);
    if across.max(down) > 0.0 {
        let (lines, ms) = if across > down { ("columns", across) } else { ("rows", down) };
        say::line!(
            "  rolling shutter: the views agree if the {lines} of an image are exposed within {ms:.0} ms, one after the other; images are put right by that"
        );
    }
    if let Some(ate) = &report.ate_m {
        say::line!("  ATE RMSE {:.4} m, median {:.4} m, max {:.4} m", ate.rmse, ate.median, ate.max);
        if report.maps.first().is_some_and(|map| map.scale.is_some()) {
            say::line!("  lengths are {:+.1} % off the truth", (1.0 / ate.scale - 1.0) * 100.0);
        }
    }
    if let (Some(rotation), Some(translation)) = (report.rpe_rot_deg, report.rpe_trans_m) {
        say::line!("  frame to frame {rotation:.3} deg, {:.2} mm", translation * 1e3);
    }
    for (name, times) in [("tracking", &report.tracking_ms), ("mapping", &report.mapping_ms)] {
        if times.stages.is_empty() {
            continue;
        }
        say::line!(
            "  {name} {:.2} ms mean, {:.2} median, {:.2} p95, {:.2} max",
            times.mean,
            times.median,
            times.p95,
            times.max
        );
        let stages: Vec<String> = times.stages.iter().map(|(stage, ms)| format!("{stage} {ms:.2}")).collect();
        say::line!("    {}", stages.join(", "));
    }
    match (report.initialized_at_s, &args.load) {
        (Some(_), _) => {}
        (None, Some(map)) => say::line!("  the camera was never found in {}", map.display()),
        (None, None) => say::line!("  no map was started"),
    }
    for line in diagnosis_lines("tracked", &report.diagnosis) {
        say::line!("  {line}");
    }
    for skipped in run.skipped.iter().take(5) {
        say::line!("  left out: {}: {}", skipped.origin, skipped.reason);
    }
    if run.skipped.len() > 5 {
        say::line!("  left out: {} more", run.skipped.len() - 5);
    }
}
