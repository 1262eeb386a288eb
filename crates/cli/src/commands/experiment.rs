//! `visloc experiment`.

use std::{
    io::{self, IsTerminal},
    path::Path,
    sync::{Arc, mpsc::Sender},
};

use anyhow::{Context, Result, bail};
use visloc_core::Clock;
use visloc_experiments::{
    Experiment, ExperimentError, Manifest, Report, Results, RunOptions, RunProgress, RunTarget,
    kidnap::KidnapExperiment,
    markov::{MarkovExperiment, MarkovSettings},
    merge,
    office::{OfficeExperiment, OfficeSettings},
    robocup::{RobocupExperiment, RobocupSet, RobocupSettings, RunLength, measure},
    run_until,
    slam::{SlamExperiment, SlamSettings, SlamStudy},
    symmetry::{SymmetryExperiment, SymmetryPart, SymmetrySettings, measure as measure_iterations},
    team::{TeamExperiment, TeamSettings},
    work_until,
};
use visloc_plot::Picture;

use crate::{
    args::{ExperimentArgs, ExperimentCommand, InputName, MergeArgs, RobocupArgs, RunsArgs, SlamStudyArgs},
    host::{host, stop_at_signals},
    report::{SkippedReport, save_json},
    run::{Progress, Saving},
    say,
    stopwatch::{Stopwatch, thread_cpu_secs},
};

/// Runs of each cell of the kidnap and Markov experiments.
const NUM_RUNS: u64 = 100;
/// Runs of each kind of the RoboCup experiment, and of its short form.
const NUM_ROBOCUP_RUNS: (u64, u64) = (20, 2);

/// Runs the command.
pub fn execute(args: &ExperimentArgs) -> Result<()> {
    match &args.command {
        ExperimentCommand::Symmetry(args) => {
            let part = if args.long { SymmetryPart::Long } else { SymmetryPart::Published };
            conduct(symmetry(part, args.runs), &args.common, |experiment, results, seed| {
                let times =
                    unless_stopped(move || measure_iterations(seed, &mut || thread_cpu_secs() * 1e3))?;
                experiment.report(results, seed, &times)
            })
        }
        ExperimentCommand::Kidnap(args) => {
            conduct(KidnapExperiment::new(args.runs), &args.common, KidnapExperiment::report)
        }
        ExperimentCommand::Markov(args) => {
            let recording = args.recording.as_deref().map(Path::to_path_buf);
            let settings = MarkovSettings { recording, ..MarkovSettings::default() };
            let experiment = MarkovExperiment::new(settings, args.cells.runs)?;
            conduct(experiment, &args.cells.common, |e, results, seed| Ok(e.report(results, seed)))
        }
        ExperimentCommand::Robocup(args) => robocup(args),
        ExperimentCommand::Office(args) => {
            let mut settings = OfficeSettings::default();
            if !args.places.is_empty() {
                settings.scenarios = names(&args.places);
            }
            if !args.algorithms.is_empty() {
                settings.algorithms.clone_from(&args.algorithms);
            }
            let experiment = OfficeExperiment::new(settings, args.runs)?;
            conduct(experiment, &args.common, |e, results, seed| Ok(e.report(results, seed)))
        }
        ExperimentCommand::Team(args) => {
            let settings = TeamSettings { secs: args.secs, ..TeamSettings::default() };
            conduct(TeamExperiment::new(settings, args.runs), &args.common, TeamExperiment::report)
        }
        ExperimentCommand::SlamConfigs(args) => slam(SlamStudy::Configs, args),
        ExperimentCommand::SlamLostPoints(args) => slam(SlamStudy::LostPoints, args),
        ExperimentCommand::SlamDynamic(args) => slam(SlamStudy::Dynamic, args),
        ExperimentCommand::SlamKidnap(args) => slam(SlamStudy::Kidnap, args),
        ExperimentCommand::SlamCompare(args) => slam(SlamStudy::Compare, args),
        ExperimentCommand::Merge(args) => merge_parts(args),
    }
}

fn names(inputs: &[InputName]) -> Vec<String> {
    inputs.iter().map(ToString::to_string).collect()
}

fn slam(study: SlamStudy, args: &SlamStudyArgs) -> Result<()> {
    let mut settings = SlamSettings::new(study, &names(&args.sequences));
    settings.max_frames = args.frames.map_or(usize::MAX, |frames| frames as usize);
    let experiment = SlamExperiment::new(settings, args.runs, Clock::new(thread_cpu_secs))?;
    experiment.warnings().iter().for_each(|warning| say::note!("{warning}"));
    SkippedReport::new(experiment.skipped()).lines().iter().for_each(|line| say::line!("{line}"));
    conduct(experiment, &args.common, |e, results, seed| Ok(e.report(results, seed)))
}

fn symmetry(part: SymmetryPart, runs: Option<u64>) -> SymmetryExperiment {
    let default = match part {
        SymmetryPart::Published => 100,
        SymmetryPart::Long => 1000,
    };
    SymmetryExperiment::new(part, runs.unwrap_or(default))
}

/// The times are measured after the runs, when the machine is quiet; they are no part of the records.
fn robocup(args: &RobocupArgs) -> Result<()> {
    let mut settings = RobocupSettings::default();
    if !args.sets.is_empty() {
        settings.sets = RobocupSet::ALL.into_iter().filter(|set| args.sets.contains(set)).collect();
    }
    if !args.algorithms.is_empty() {
        settings.algorithms.clone_from(&args.algorithms);
    }
    settings.features = args.features.to_vec();
    if args.quick {
        settings.length = RunLength::QUICK;
    }
    let (usual, quick) = NUM_ROBOCUP_RUNS;
    let num_runs = args.seeds.unwrap_or(if args.quick { quick } else { usual });
    let experiment = RobocupExperiment::new(settings, num_runs)?;
    conduct(experiment, &args.common, |experiment, results, seed| {
        let settings = experiment.settings().clone();
        let timings = unless_stopped(move || {
            let watch = Stopwatch::start();
            measure(&RobocupExperiment::new(settings, 1)?, seed, &mut || watch.ms())
        })?;
        experiment.report(results, seed, &timings)
    })
}

/// What is worked out; nothing after an interruption: whoever interrupts does not wait for it.
fn unless_stopped<T: Send + 'static>(
    work: impl FnOnce() -> Result<Vec<T>, ExperimentError> + Send + 'static,
) -> Result<Vec<T>, ExperimentError> {
    let mut found = None;
    if !host().is_stopped() {
        let work = move |sender: Sender<_>| drop(sender.send(work()));
        work_until(&host().stop_sign(), work, &mut |all| found = Some(all));
    }
    found.unwrap_or_else(|| {
        host().note_interruption();
        Ok(Vec::new())
    })
}

/// What makes a report of an experiment's records.
type MakeReport<E> = fn(&E, &Results<<E as Experiment>::Record>, u64) -> Result<Report, ExperimentError>;

/// Does the runs that are not there yet and shows what all of them found.
fn conduct<E: Experiment<Record: 'static> + Send + 'static>(
    experiment: E,
    args: &RunsArgs,
    report: MakeReport<E>,
) -> Result<()> {
    let stopwatch = Stopwatch::start();
    let target = args.out.as_deref().map_or(RunTarget::Memory, RunTarget::Folder);
    let options = RunOptions { seed: args.seed.value(), shard: args.shard, target };
    let progress = Progress::runs();
    let mut watch = |done: RunProgress| progress.set(done.num_done, done.num_wanted);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build()?;
    let experiment = Arc::new(experiment);
    stop_at_signals();
    let results = run_until(&experiment, &options, &Arc::new(pool), &host().stop_sign(), &mut watch);
    progress.clear();
    let results = results?;
    if host().is_stopped() {
        host().note_interruption();
        say::line!(
            "{} of {} runs are done; with --out the same command goes on with the others\n",
            results.num_runs() - results.num_missing(),
            results.num_runs()
        );
    } else if results.num_missing() > 0 {
        say::line!(
            "{} of {} runs are there, {} belong to other parts (see: visloc experiment merge)\n",
            results.num_runs() - results.num_missing(),
            results.num_runs(),
            results.num_missing()
        );
    }
    let seed = args.seed.value();
    let mut report = report(&experiment, &results, seed)?;
    report.pictures.extend(unless_stopped(move || experiment.pictures_of_runs(&results, seed))?);
    show(&report, args.out.as_deref(), args.json.json.as_deref())?;
    if io::stderr().is_terminal() {
        eprintln!("{:.1} s", stopwatch.secs());
    }
    Ok(())
}

fn show(report: &Report, folder: Option<&Path>, json: Option<&Path>) -> Result<()> {
    say::text(format_args!("{}", report.text()));
    let mut saving = Saving::default();
    saving.save_if(json, |path| save_json(path, &report.json));
    saving.save_if(folder, |folder| {
        report.save(folder)?;
        say::line!("\ntables and pictures: {}", folder.display());
        Ok(())
    });
    saving.end()
}

/// The settings of the runs in a folder.
fn settings_of<T: serde::de::DeserializeOwned>(manifest: &Manifest, folder: &Path) -> Result<T> {
    serde_json::from_value(manifest.settings.clone())
        .with_context(|| format!("{}: settings of another version", folder.display()))
}

fn merge_parts(args: &MergeArgs) -> Result<()> {
    let folders: Vec<&Path> = args.folders.iter().map(|folder| &**folder).collect();
    let Merged { mut report, draw } = merge_folders(&folders, args.runs)?;
    report.pictures.extend(draw()?);
    show(&report, args.out.as_deref(), args.json.json.as_deref())
}

/// What parts have found together, but for pictures of runs. Which experiment they are of is written in their folders.
pub fn merged(folders: &[&Path], num_runs: Option<u64>) -> Result<Report> {
    Ok(merge_folders(folders, num_runs)?.report)
}

/// Draws pictures of runs.
type Draw = Box<dyn FnOnce() -> Result<Vec<(String, Picture)>, ExperimentError>>;

struct Merged {
    report: Report,
    draw: Draw,
}

impl Merged {
    fn new<E: Experiment<Record: 'static> + 'static>(
        experiment: E,
        seed: u64,
        folders: &[&Path],
        report: MakeReport<E>,
    ) -> Result<Self> {
        let results = merge(&experiment, seed, folders)?;
        let report = report(&experiment, &results, seed)?;
        Ok(Self { report, draw: Box::new(move || experiment.pictures_of_runs(&results, seed)) })
    }
}

fn merge_folders(folders: &[&Path], num_runs: Option<u64>) -> Result<Merged> {
    let first = *folders.first().context("expected at least one folder")?;
    let manifest = Manifest::read(first)?;
    let seed = manifest.seed;
    match manifest.experiment.as_str() {
        "symmetry" => {
            let settings: SymmetrySettings = settings_of(&manifest, first)?;
            Merged::new(symmetry(settings.part, num_runs), seed, folders, |e, results, seed| {
                e.report(results, seed, &[])
            })
        }
        "kidnap" => {
            let experiment = KidnapExperiment::new(num_runs.unwrap_or(NUM_RUNS));
            Merged::new(experiment, seed, folders, KidnapExperiment::report)
        }
        "markov" => {
            let settings: MarkovSettings = settings_of(&manifest, first)?;
            // To take them again would take as long as somebody has written there.
            if settings.captures.is_some() {
                bail!("{}: holds runs with tables of captures, which no command takes", first.display());
            }
            let experiment = MarkovExperiment::new(settings, num_runs.unwrap_or(NUM_RUNS))?;
            Merged::new(experiment, seed, folders, |e, results, seed| Ok(e.report(results, seed)))
        }
        "robocup" => {
            let settings: RobocupSettings = settings_of(&manifest, first)?;
            let experiment = RobocupExperiment::new(settings, num_runs.unwrap_or(NUM_ROBOCUP_RUNS.0))?;
            Merged::new(experiment, seed, folders, |e, results, seed| e.report(results, seed, &[]))
        }
        "office" => {
            let settings: OfficeSettings = settings_of(&manifest, first)?;
            let experiment = OfficeExperiment::new(settings, num_runs.unwrap_or(5))?;
            Merged::new(experiment, seed, folders, |e, results, seed| Ok(e.report(results, seed)))
        }
        "team" => {
            let settings: TeamSettings = settings_of(&manifest, first)?;
            let experiment = TeamExperiment::new(settings, num_runs.unwrap_or(25));
            Merged::new(experiment, seed, folders, TeamExperiment::report)
        }
        name if name.starts_with("slam-") => {
            let settings: SlamSettings = settings_of(&manifest, first)?;
            let experiment = SlamExperiment::new(settings, num_runs.unwrap_or(3), Clock::still())?;
            Merged::new(experiment, seed, folders, |e, results, seed| Ok(e.report(results, seed)))
        }
        other => bail!("{}: holds runs of an unknown experiment {other:?}", first.display()),
    }
}
