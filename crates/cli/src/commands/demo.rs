//! `visloc demo`: watch a simulated robot find itself.

use std::path::Path;

use anyhow::Result;
use visloc_io::trajectory::write_tum;
use visloc_locate::{FeatureChoice, PipelineConfig, StartPrior};
use visloc_plot::Picture;
use visloc_world::Map;

use super::demo_slam;
use crate::{
    args::{DemoArgs, DemoKind},
    live_view::{LiveView, PlainLog, is_live_terminal},
    report::{
        AlgorithmReport, Column, Curve, DemoReport, RunPictures, SnapshotTaker, comparison_table,
        diagnosis_lines, measure, save_json,
    },
    run::{
        FrameRecord, OutputFiles, Progress, RunOutcome, Runner, RunnerSettings, Saving, Spectator, drive,
        simulation, until_stopped,
    },
    say,
};

/// Who looks for the robot.
/// Algorithm, name in the output, and what poses are computed from.
const ALGORITHMS: [(&str, &str, FeatureChoice); 2] = [
    ("evolutionary", "evolutionary", FeatureChoice::Rich),
    ("mcae", "mcae, 20 pixels", FeatureChoice::Pixels),
];

/// Runs the command.
pub fn execute(args: &DemoArgs) -> Result<()> {
    match args.kind {
        DemoKind::Field => on_the_field(args),
        DemoKind::Slam => demo_slam::execute(args),
    }
}

fn on_the_field(args: &DemoArgs) -> Result<()> {
    let simulation = simulation(args.scenario(), args.seed.value(), args.threads.count(), args.frames)?;
    let map = simulation.map().clone();
    let summary = simulation.scenario().summary.clone();
    let mut frames = until_stopped(simulation);
    let mut runners = start_runners(args, &map)?;
    say::line!("visloc demo: {summary}; where is the robot?");
    say::line!(
        "Two algorithms look for it in the same images: {} with all borders in view, and",
        ALGORITHMS[0].0
    );
    say::line!("{} with twenty pixels, as published in 2010.\n", ALGORITHMS[1].0);
    let mut snapshots = SnapshotTaker::default();
    let live = is_live_terminal().then(|| LiveView::new(&map, ALGORITHMS.len())).flatten();
    let mut viewer: Box<dyn Spectator> = match live {
        Some(live) => Box::new(live),
        None => Box::new(PlainLog::new(ALGORITHMS.len())),
    };
    let outcome = drive(&mut frames, None, &mut runners, &mut [viewer.as_mut(), &mut snapshots]);
    drop(viewer);
    let mut saving = Saving::default();
    runners.iter_mut().for_each(|runner| saving.save(runner.finish()));
    let report = DemoReport {
        scenario: args.scenario().to_owned(),
        map: map.name().to_owned(),
        seed: args.seed.value(),
        duration_s: outcome.duration_secs,
        wall_s: outcome.wall_secs,
        algorithms: runners.iter().map(|runner| AlgorithmReport::new(runner, &outcome)).collect(),
    };
    print_table(&report);
    let analysis = snapshots.snapshot().map(|snapshot| snapshot.draw());
    let results = Results { map: &map, runners: &runners, outcome: &outcome, analysis };
    save(args, &report, &results, &mut saving);
    saving.save(outcome.error.map_or(Ok(()), Err));
    saving.end()?;
    print_next_steps(&args.out);
    Ok(())
}

fn start_runners(args: &DemoArgs, map: &Map) -> Result<Vec<Runner>> {
    let start = |(algorithm, name, features): &(&'static str, &str, FeatureChoice)| {
        let file = |extension: &str| args.out.join(format!("{algorithm}.{extension}"));
        let files = OutputFiles::create(Some(&file("tum")), Some(&file("csv")))?;
        let settings = RunnerSettings {
            algorithm,
            algorithm_toml: None,
            pipeline: PipelineConfig { features: *features, ..PipelineConfig::default() },
            start: StartPrior::Uniform,
            seed: args.seed.value(),
        };
        Ok(Runner::new(map, &settings)?.writing(files).named(name))
    };
    ALGORITHMS.iter().map(start).collect()
}

fn print_table(report: &DemoReport) {
    say::line!();
    let columns = report.algorithms.iter();
    let columns = columns.map(|a| Column { title: &a.algorithm, report: &a.evaluation });
    say::text(format_args!("{}", comparison_table(&columns.collect::<Vec<_>>())));
    for algorithm in &report.algorithms {
        for line in diagnosis_lines(&format!("localized by {}", algorithm.algorithm), &algorithm.diagnosis) {
            say::line!("{line}");
        }
    }
}

struct Results<'a> {
    map: &'a Map,
    runners: &'a [Runner],
    outcome: &'a RunOutcome,
    analysis: Option<Picture>,
}

/// Numbers first, pictures last.
fn save(args: &DemoArgs, report: &DemoReport, results: &Results<'_>, saving: &mut Saving) {
    let bar = Progress::message("drawing pictures");
    saving.save(save_json(&args.out.join("summary.json"), report));
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, report));
    saving.save(write_tum(&args.out.join("truth.tum"), &results.outcome.truth));
    let curve = |(runner, report)| {
        let (runner, report): (&Runner, &AlgorithmReport) = (runner, report);
        Curve {
            label: runner.name(),
            samples: runner.records().iter().map(FrameRecord::sample).collect(),
            comparison: report.comparison.as_ref(),
            individuals: runner.records().iter().map(|record| (record.at, record.num_individuals)).collect(),
        }
    };
    let means = report.algorithms.iter().map(|algorithm| {
        let mean_m = algorithm.evaluation.position_error_m.and_then(|error| error.mean);
        format!("{} {}", algorithm.algorithm, measure(mean_m, " m", 2))
    });
    let pictures = RunPictures {
        title: format!("visloc demo: scenario {}, seed {}", report.scenario, report.seed),
        subtitle: format!("mean position error: {}", means.collect::<Vec<_>>().join(", ")),
        map: Some(results.map),
        truth: &results.outcome.truth,
        curves: results.runners.iter().zip(&report.algorithms).map(curve).collect(),
    };
    saving.save(pictures.save(&args.out).map(drop));
    saving.save_if(results.analysis.as_ref(), |analysis| Ok(analysis.save(&args.out, "analysis")?));
    bar.clear();
}

fn print_next_steps(out: &Path) {
    let out = out.display();
    say::line!();
    say::line!("In {out}:");
    say::line!("  trajectories.svg   where the robot was and where they thought it was");
    say::line!("  errors.svg         errors and reliability over time");
    say::line!("  individuals.svg    how many particles or exploiters each needed");
    say::line!("  analysis.svg       what the image analysis keeps and drops, and why");
    say::line!("  *.tum, *.csv       where they thought it was, frame by frame");
    say::line!("  summary.json       all numbers");
    if cfg!(feature = "png") {
        say::line!("  (pictures also as .png)");
    }
    say::line!();
    say::line!("Next:");
    say::line!("  visloc demo --seed 2                                       other places, other kidnaps");
    say::line!("  visloc demo slam                                           a camera without a map");
    say::line!("  visloc localize sim:crowd --plots out/crowd                among other robots");
    say::line!("  visloc localize recording.mcap --map robocup-spl-2010      your own ROS 2 bag");
}
