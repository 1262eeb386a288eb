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

/// Letters of a line below the table.
const MAX_LETTERS: usize = 300;

/// Runs the command.
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
        let below = folders.iter().map(|folder| format!(", none below {}", folder.display()));
        let found = match unused.is_empty() {
            true => format!("none among the scenarios of the simulator{}", below.collect::<String>()),
            false => format!("only {}", unused.join(". ")),
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
    let changes = args.baseline.as_deref().zip(baseline);
    let changes = changes.map(|(folder, cells)| (folder.display().to_string(), compare(&rows, &cells)));
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
    let mut seeds: Vec<(&str, u64)> =
        plan.runs().map(|run| (run.key.contender.as_str(), run.key.seed)).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let each = seeds.chunk_by(|a, b| a.0 == b.0).map(|same| format!("{} of {}", same.len(), same[0].0));
    facts.push(format!("Runs on each recording: {}.", each.collect::<Vec<_>>().join("; ")));
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

fn print(rows: &[Row<'_>], account: &Account) {
    account.facts.iter().for_each(|fact| say::line!("{fact}\n"));
    say::text(format_args!("{}", for_screens(rows).text()));
    for (title, lines) in account.lists(rows) {
        say::line!("\n{title}:");
        lines.iter().for_each(|line| say::line!("  {}", shortened(line)));
    }
}

fn shortened(line: &str) -> String {
    let short: String = line.chars().take(MAX_LETTERS).collect();
    if short.len() < line.len() { short + " ..." } else { short }
}
