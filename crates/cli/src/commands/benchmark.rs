//! `visloc benchmark`.

use std::path::Path;

use anyhow::{Result, bail};

use crate::{
    args::{BenchmarkArgs, num_cores},
    benchmark::{
        Account, Claims, Limits, Plan, Recording, Row, Store, compare, find, for_screens, measure_accuracy,
        measure_times, program, save,
    },
    host::{host, stop_at_signals},
    run::Saving,
    say,
    stopwatch::Stopwatch,
};

/// Files that are named where no recording is left.
const MAX_NAMED: usize = 3;

/// Files without use that are listed on the screen, and letters of each line.
const MAX_LISTED: usize = 12;
const MAX_LETTERS: usize = 200;

/// Runs the command.
///
/// # Errors
/// If a folder is not there or cannot be written, or if nothing of what is asked for could be measured.
pub fn execute(args: &BenchmarkArgs) -> Result<()> {
    let watch = Stopwatch::start();
    let baseline = args.baseline.as_deref().map(|folder| Store::new(folder).all()).transpose()?;
    let claims = Claims::built_in()?;
    let folders: Vec<&Path> = args.data.iter().map(|folder| &**folder).collect();
    let (mut recordings, unused) = find(&folders, &claims)?;
    let is_wanted = |recording: &Recording| {
        let names = [&recording.name, &recording.class];
        args.only.is_empty() || args.only.iter().any(|part| names.iter().any(|name| name.contains(part)))
    };
    recordings.retain(is_wanted);
    if recordings.is_empty() {
        let found: Vec<String> = unused.iter().take(MAX_NAMED).map(ToString::to_string).collect();
        let below: Vec<String> =
            folders.iter().map(|folder| format!(", none below {}", folder.display())).collect();
        let found = match found.is_empty() {
            true => format!("none among the scenarios of the simulator{}", below.concat()),
            false => format!("only {}", found.join("; ")),
        };
        bail!(
            "--only {}: expected a recording or class whose name contains it, found {found}",
            args.only.join(", ")
        );
    }
    let limits = Limits { is_quick: args.quick, seeds: args.seeds, frames: args.frames };
    let program = program();
    let plan = Plan::new(&claims, &recordings, &limits, &program)?;
    let store = Store::new(&args.out);
    stop_at_signals();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build()?;
    let mut failures = pool.install(|| measure_accuracy(&plan, &store))?;
    let accuracy_secs = watch.secs();
    if !host().is_stopped() {
        failures.extend(measure_times(&plan, &store)?);
    }
    if host().is_stopped() {
        host().note_interruption();
        say::line!("Not all runs are done; the same command goes on with the others.\n");
    }
    let wanted = || plan.runs().chain(&plan.times);
    let cells: Vec<_> = wanted().filter_map(|run| store.find(&run.key)).collect();
    let rows = Row::all(&claims, &cells);
    let facts = facts(args, &plan, cells.len(), (accuracy_secs, watch.secs()));
    let changes = baseline.map(|baseline| (place(args.baseline.as_deref()), compare(&rows, &baseline)));
    let account = Account { facts, unused, failures, changes };
    print(&rows, &account);
    let mut saving = Saving::default();
    saving.save(save(&args.out, &claims, &rows, &account));
    say::line!("\nreport: {}", args.out.join("report.html").display());
    if rows.is_empty() && !host().is_stopped() {
        saving.save(Err(anyhow::anyhow!("no run has worked; the reasons stand above")));
    }
    saving.end()
}

fn place(folder: Option<&Path>) -> String {
    folder.map(|folder| folder.display().to_string()).unwrap_or_default()
}

/// What was done, for the head of the report.
fn facts(args: &BenchmarkArgs, plan: &Plan<'_>, num_done: usize, secs: (f64, f64)) -> Vec<String> {
    let num_wanted = plan.runs().count() + plan.times.len();
    let mut recordings: Vec<&str> = plan.runs().map(|run| run.recording.name.as_str()).collect();
    recordings.dedup();
    let mut facts = vec![format!(
        "visloc {}, {} cores. {num_done} of {num_wanted} runs on {} recordings are there; seeds from 101 on, with which nothing was \
         chosen. This call took {:.0} s for accuracy and {:.0} s for times.",
        program(),
        num_cores(),
        recordings.len(),
        secs.0,
        secs.1 - secs.0,
    )];
    facts.push(format!("Runs on each recording: {}.", runs_of_each(plan).join("; ")));
    if args.quick || args.frames.is_some() {
        facts.push(
            "Excerpts: not to be set beside figures of whole recordings, and not to be quoted.".to_owned(),
        );
    }
    let folders: Vec<String> = args.data.iter().map(|folder| folder.display().to_string()).collect();
    if !folders.is_empty() {
        facts.push(format!("Recordings from {}.", folders.join(", ")));
    }
    facts
}

/// How many seeds each of the settings has.
fn runs_of_each(plan: &Plan<'_>) -> Vec<String> {
    let mut seeds: Vec<(&str, u64)> =
        plan.runs().map(|run| (run.key.contender.as_str(), run.key.seed)).collect();
    seeds.sort_unstable();
    seeds.dedup();
    seeds.chunk_by(|a, b| a.0 == b.0).map(|same| format!("{} of {}", same.len(), same[0].0)).collect()
}

fn print(rows: &[Row<'_>], account: &Account) {
    account.facts.iter().for_each(|fact| say::line!("{fact}\n"));
    say::text(format_args!("{}", for_screens(rows).text()));
    for (command, reason) in &account.failures {
        say::line!("\ndid not work: visloc {command}: {reason}");
    }
    if !account.unused.is_empty() {
        say::line!("\nfound, but not used:");
    }
    for unused in account.unused.iter().take(MAX_LISTED) {
        say::line!("  {}", shortened(&unused.to_string()));
    }
    if account.unused.len() > MAX_LISTED {
        say::line!("  and {} more; all stand in the report in full", account.unused.len() - MAX_LISTED);
    }
    if let Some((place, _)) = &account.changes {
        say::line!("\nsince {place}:");
        account.change_lines().iter().for_each(|line| say::line!("  {line}"));
    }
}

fn shortened(line: &str) -> String {
    let short: String = line.chars().take(MAX_LETTERS).collect();
    if short.len() < line.len() { short + " ..." } else { short }
}
