//! Runs for times and memory: the program itself as a user calls it, one at a time.

use std::{
    collections::BTreeMap,
    env, fs,
    io::Read,
    process::{Command, Stdio},
    thread,
    time::Duration,
};

use anyhow::{Context, Result};
use serde_json::Value;
use visloc_core::files;

use super::{
    Kind,
    plan::{Plan, Run},
    quantities::Quantity,
    store::{Cell, Store},
};
use crate::{host::host, run::Progress, say::one_line};

/// Between two looks whether a program has ended.
const WAIT: Duration = Duration::from_millis(10);

/// Does the runs that are not there yet, and returns what did not work, with the reason.
pub fn measure_times(plan: &Plan<'_>, store: &Store) -> Result<Vec<(String, String)>> {
    let progress = Progress::runs();
    let mut failures = Vec::new();
    for (number, run) in plan.times.iter().enumerate() {
        progress.set(number, plan.times.len());
        if store.find(&run.key).is_some() {
            continue;
        }
        let measured = measure(run, store);
        if host().is_stopped() {
            break;
        }
        match measured {
            Ok(cell) => store.add(&cell)?,
            Err(error) => failures.push((run.key.words.join(" "), one_line(&error))),
        }
    }
    progress.clear();
    let _ = fs::remove_file(store.scratch());
    Ok(failures)
}

fn measure(run: &Run<'_>, store: &Store) -> Result<Cell> {
    let numbers = store.scratch();
    let mut command = Command::new(env::current_exe()?);
    command.args(&run.key.words).arg("--json").arg(&numbers);
    if run.recording.is_simulated() && run.recording.kind == Kind::Map {
        command.args(["--threads", "1"]);
    }
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if host().is_stopped() {
            let _ = child.kill();
        }
        thread::sleep(WAIT);
    };
    if !status.success() {
        let mut said = String::new();
        child.stderr.take().map(|mut stderr| stderr.read_to_string(&mut said)).transpose()?;
        anyhow::bail!("{}", said.trim().trim_start_matches("error: "));
    }
    let text = files::read_text(&numbers)?;
    let report: Value = serde_json::from_str(&text).context("the numbers of a run")?;
    let image_ms = match run.recording.kind {
        Kind::Map => report["iteration_ms"]["median"].as_f64(),
        Kind::Slam => report["tracking_ms"]["median"].as_f64().filter(|ms| *ms > 0.0),
    };
    let frames = report["frames"].as_f64().filter(|frames| *frames > 0.0);
    let program_ms = report["process_cpu_s"].as_f64().zip(frames).map(|(secs, frames)| 1e3 * secs / frames);
    // The simulator draws its images in the same program.
    let is_alone = !run.recording.is_simulated();
    let figures = [
        (Quantity::TimeMs, image_ms),
        (Quantity::ProgramMs, program_ms.filter(|_| is_alone)),
        (Quantity::MemoryMb, report["peak_memory_mb"].as_f64().filter(|_| is_alone)),
    ];
    let figures: BTreeMap<_, _> =
        figures.into_iter().filter_map(|(quantity, v)| Some((quantity, v?))).collect();
    Ok(Cell { key: run.key.clone(), figures, truth: Vec::new(), estimate: Vec::new() })
}
