//! `visloc simulate`: a simulated robot's recording.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use visloc_base::{FrameSource, PlanarTrajectory, StampedPose};
use visloc_data::{
    bag::{BagTopics, BagWriter},
    trajectory::write_tum,
};
use visloc_sim::{BUILT_IN_SCENARIOS, Scenario};

use crate::{
    args::SimulateArgs,
    report::{SimulateReport, save_json},
    run::{Progress, simulation},
    say,
};

/// Runs the command.
///
/// # Errors
/// If the scenario cannot be used or the bag not be written.
pub fn execute(args: &SimulateArgs) -> Result<()> {
    let Some(scenario) = &args.scenario else { return list() };
    let bag = &args.out.clone().unwrap_or_else(|| default_bag(scenario));
    let mut simulation = simulation(scenario, args.seed.seed, args.threads.count(), args.frames)?;
    if let Some(folder) = bag.parent() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    }
    let mut writer = BagWriter::create(bag, BagTopics::default())?;
    let progress = Progress::new(simulation.num_frames());
    let mut truth = PlanarTrajectory::new();
    while let Some(next) = simulation.next_frame() {
        let next = next?;
        writer.write(&next)?;
        if let Some(known) = next.truth {
            let (world_from_robot, height_m) = (known.world_from_robot, known.height_m);
            truth
                .push(StampedPose { at: next.frame.at, world_from_robot, height_m })
                .map_err(|refused| anyhow!("two frames at {}", refused.at))?;
        }
        progress.advance();
    }
    writer.finish()?;
    progress.clear();
    let truth_path = truth_path(bag);
    write_tum(&truth_path, &truth)?;
    let duration_s = match (truth.poses().first(), truth.poses().last()) {
        (Some(first), Some(last)) => last.at.secs_since(first.at),
        _ => 0.0,
    };
    let report = SimulateReport {
        scenario: scenario.clone(),
        map: simulation.map().name().to_owned(),
        seed: args.seed.seed,
        frames: truth.poses().len(),
        duration_s,
        bag: bag.display().to_string(),
        truth: truth_path.display().to_string(),
    };
    say::line!("{}: {} frames, {:.1} s", report.bag, report.frames, report.duration_s);
    say::line!("{}: the truth", report.truth);
    say::line!("next: visloc localize {} --map {}", report.bag, simulation.scenario().map);
    args.json.json.as_deref().map_or(Ok(()), |path| save_json(path, &report))
}

/// Where the bag goes if nobody says it: named as the scenario or its file.
fn default_bag(scenario: &str) -> PathBuf {
    let name = Path::new(scenario).file_stem().unwrap_or_default();
    Path::new("out").join(name).with_extension("mcap")
}

/// `BAG.truth.tum` beside a file, `truth.tum` in a folder.
fn truth_path(bag: &Path) -> PathBuf {
    if bag.extension().is_some_and(|extension| extension == "mcap") {
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
