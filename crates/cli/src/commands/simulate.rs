//! `visloc simulate`: a simulated robot's recording.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use visloc_core::{PlanarTrajectory, Source, SourceFrame, StampedPose, Truth};
use visloc_io::{
    bag::{BagTopics, BagWriter},
    trajectory::write_tum,
};
use visloc_sim::{BUILT_IN_SCENARIOS, Scenario};

use crate::{
    args::SimulateArgs,
    claims::Claims,
    report::{SimulateReport, save_json},
    run::{Progress, Saving, simulation, until_stopped},
    say,
};

/// Runs the command.
pub fn execute(args: &SimulateArgs) -> Result<()> {
    let Some(scenario) = args.scenario() else { return list() };
    let bag = &args.out.as_deref().map_or_else(|| default_bag(scenario), Path::to_path_buf);
    let truth_path = truth_path(bag);
    let json = args.json.json.as_deref().map(|json| ("--json", json));
    // In a folder it is a part of the recording.
    let truth_beside = (!truth_path.starts_with(bag)).then_some(("the truth", &*truth_path));
    let beside = truth_beside.into_iter().chain(json);
    let out = ("--out", &**bag);
    let claims = Claims::of_recording(("SCENARIO", scenario), out, beside, args.overwrite.overwrite);
    claims.check()?;
    let simulation = simulation(scenario, args.seed.value(), args.threads.count(), args.frames)?;
    let (map, map_name) = (simulation.scenario().map.clone(), simulation.map().name().to_owned());
    let writer = BagWriter::create(bag, BagTopics::default())?;
    let mut saving = Saving::default();
    let is_empty = simulation.status().num_items == Some(0);
    let (truth, num_frames) = write(until_stopped(simulation), writer, &mut saving);
    if is_empty {
        bail!("{scenario}: expected a scenario of at least one frame; duration_secs is too short for any");
    }
    let truth_written = write_tum(&truth_path, &truth);
    let has_truth = truth_written.is_ok();
    saving.save(truth_written);
    claims.say_kept();
    let duration_s = match (truth.poses().first(), truth.poses().last()) {
        (Some(first), Some(last)) => last.at.secs_since(first.at),
        _ => 0.0,
    };
    let report = SimulateReport {
        scenario: scenario.to_string(),
        map: map_name,
        seed: args.seed.value(),
        frames: num_frames,
        duration_s,
        bag: bag.display().to_string(),
        truth: truth_path.display().to_string(),
    };
    say::line!("{}: {}, {:.1} s", report.bag, say::count(report.frames, "frame"), report.duration_s);
    if has_truth {
        say::line!("{}: the truth", report.truth);
    }
    if saving.is_complete() {
        say::line!("next: visloc localize {} --map {}", say::typed(&report.bag), say::typed(&map));
    }
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.end()
}

/// Writes all frames; the truth of those that are written, and how many they are.
fn write(
    mut frames: impl Source<SourceFrame>,
    mut writer: BagWriter,
    saving: &mut Saving,
) -> (PlanarTrajectory, usize) {
    let progress = Progress::new(frames.status().num_items);
    let (mut truth, mut num_frames) = (PlanarTrajectory::new(), 0);
    while let Some(next) = frames.next_item() {
        let written = next.map_err(anyhow::Error::from).and_then(|next| {
            writer.write(&next)?;
            Ok(next)
        });
        let next = match written {
            Ok(next) => next,
            Err(error) => {
                saving.save(Err(error));
                break;
            }
        };
        if let Some(Truth { world_from_robot, height_m }) = next.truth {
            // A second truth of the same time tells nothing new.
            let _ = truth.push(StampedPose { at: next.frame.at, world_from_robot, height_m });
        }
        num_frames += 1;
        progress.advance();
    }
    saving.save(writer.finish());
    progress.clear();
    (truth, num_frames)
}

/// Where the bag goes if nobody says it: named as the scenario or its file.
fn default_bag(scenario: &str) -> PathBuf {
    let name = Path::new(scenario).file_stem().unwrap_or_default();
    Path::new("out").join(name).with_extension("mcap")
}

/// `BAG.truth.tum` beside a file, `truth.tum` in a folder.
fn truth_path(bag: &Path) -> PathBuf {
    if bag.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap")) {
        bag.with_extension("truth.tum")
    } else {
        bag.join("truth.tum")
    }
}

fn list() -> Result<()> {
    for (name, text) in BUILT_IN_SCENARIOS {
        let scenario = Scenario::parse(name, text)?;
        say::line!("{name:<18} {} ({:.0} s, {})", scenario.summary, scenario.duration_secs, scenario.map);
    }
    Ok(())
}
