//! `visloc demo slam`: a camera in a room that nobody knows.

use std::path::Path;

use anyhow::{Result, anyhow};
use visloc_core::{CameraTrajectory, ImageSource};
use visloc_io::{sequence::write_camera_trajectory, sources::UntilStopped};
use visloc_sim::CameraTour;
use visloc_slam::SlamConfig;

use crate::{
    args::DemoArgs,
    host::{host, stop_source_at_signals},
    report::save_json,
    run::{Progress, Saving},
    say,
    slam::{FramePictures, Lookers, RunOptions, SlamReport, SlamRun, draw, run, write_ply},
    stopwatch::Stopwatch,
};

/// Frames between pictures of single frames.
const PICTURE_EVERY: usize = 100;

/// Runs the demo.
pub fn execute(args: &DemoArgs) -> Result<()> {
    let (name, out) = (args.scenario(), &*args.out);
    let mut tour = CameraTour::new(name, args.seed.value())?.with_threads(args.threads.count());
    if let Some(frames) = args.frames {
        tour = tour.with_frames(0, frames as usize, 1);
    }
    let truth = tour.truth();
    stop_source_at_signals();
    let mut tour: UntilStopped<Box<dyn ImageSource>> = UntilStopped::new(Box::new(tour), host());
    say::line!("visloc demo slam: a camera is carried through a room ({name}); nobody tells it anything.");
    say::line!("Where was it, and what did it see?\n");
    let watch = Stopwatch::start();
    let mut pictures = FramePictures::new(out, PICTURE_EVERY);
    let options = RunOptions { seed: args.seed.value(), ..RunOptions::default() };
    let lookers = Lookers { pictures: Some(&mut pictures), ..Lookers::default() };
    let run = run(&mut tour, &SlamConfig::default(), options, lookers)?;
    let (report, error) = SlamReport::new(&run, Some(&truth));
    print(&run, &report, &truth, watch.secs());
    let bar = Progress::message("drawing pictures");
    let title = format!("visloc demo slam: {name}, seed {}", args.seed.value());
    let mut saving = Saving::default();
    saving.save(save_json(&out.join("summary.json"), &report));
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.save(write_camera_trajectory(&out.join("estimate.tum"), run.trajectory.poses(), false));
    saving.save(write_camera_trajectory(&out.join("truth.tum"), truth.poses(), true));
    saving.save(write_ply(&out.join("map.ply"), &run.map, run.slam.camera(), "map units"));
    saving.save(draw(out, &title, &run, Some(&truth), error.as_ref()));
    saving.save(pictures.finish());
    saving.save(run.error.as_ref().map_or(Ok(()), |error| Err(anyhow!(error.clone()))));
    bar.clear();
    saving.end()?;
    print_next_steps(out);
    Ok(())
}

fn print(run: &SlamRun, report: &SlamReport, truth: &CameraTrajectory, secs: f64) {
    let positions = truth.poses().iter().map(|pose| *pose.world_from_camera.translation());
    let positions: Vec<_> = positions.collect();
    let way_m: f64 = positions.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let images = say::count(report.frames, "image");
    say::line!("{images}, a way of {way_m:.1} m, drawn and followed in {secs:.0} s");
    match report.initialized_at_s {
        Some(at) => say::line!("  the map was started after {at:.1} s"),
        None => say::line!("  no map was started"),
    }
    say::line!(
        "  {:.1} % of the images have a pose; lost {}, found again {}",
        report.coverage * 100.0,
        say::count(report.lost_spells, "time"),
        say::count(report.relocalizations, "time")
    );
    say::line!("  the map: {} points seen from {} keyframes", report.points, report.keyframes);
    if let Some(ate) = &report.ate_m {
        say::line!(
            "  error: {:.1} mm (RMSE; largest {:.1} mm), after the scale, which one camera cannot know, is set",
            ate.rmse * 1e3,
            ate.max * 1e3
        );
    }
    let num_tracked = run.history.num_tracked;
    say::line!(
        "  {:.1} ms of one core for each of {num_tracked} tracked images, {:.0} ms for a keyframe",
        report.tracking_ms.mean,
        report.mapping_ms.mean
    );
}

fn print_next_steps(out: &Path) {
    let out = out.display();
    say::line!();
    say::line!("In {out}:");
    say::line!(
        "  trajectory.png       where the camera was, where it thought it was, and the map, from above"
    );
    say::line!("  trajectory-side.png  the same from the side");
    say::line!("  courses.png          error, landmarks and times over time");
    say::line!("  frame-*.png          what it recognized in some images");
    say::line!("  map.ply              the map, for a 3-D viewer");
    say::line!("  *.tum, summary.json  poses and numbers");
    say::line!("  (pictures also as .svg)");
    say::line!();
    say::line!("Next:");
    say::line!("  visloc demo slam --scenario kidnap              covered, carried away, found again");
    say::line!("  visloc slam sim:walking --plots out/walking     people walk through the picture");
    say::line!("  visloc slam FOLDER --plots out/run              your own images (docs/datasets.md)");
}
