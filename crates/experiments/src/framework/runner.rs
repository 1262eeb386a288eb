//! Doing the runs.

use std::{
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
};

use rayon::prelude::*;
use visloc_core::RngTree;

use super::{
    Experiment, ExperimentError, Results, Shard,
    store::{Manifest, Store, read_records},
};

/// Where the records go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunTarget<'a> {
    /// Into memory only.
    Memory,
    /// Into a folder as well. What is already there is not run again.
    Folder(&'a Path),
}

/// Which runs are done, and where the records go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunOptions<'a> {
    /// Seed of all runs.
    pub seed: u64,
    /// The part that is run.
    pub shard: Shard,
    /// Where the records go.
    pub target: RunTarget<'a>,
}

/// How far the runs have come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunProgress {
    /// Runs that are done.
    pub num_done: usize,
    /// Runs that were to be done.
    pub num_wanted: usize,
}

/// Does the runs of an experiment that are not there yet, in parallel on the current pool of threads, and calls
/// `watch` from time to time. The results are all records that are there, also those of other parts in the same folder.
/// They do not depend on the number of threads.
///
/// # Errors
/// If a run is impossible, or the folder holds something else or cannot be written.
pub fn run<E: Experiment>(
    experiment: &E,
    options: &RunOptions<'_>,
    watch: &mut dyn FnMut(RunProgress),
) -> Result<Results<E::Record>, ExperimentError> {
    run_until(experiment, options, &AtomicBool::new(false), watch)
}

/// As [`run`], but when the sign is set, runs that have begun are the last.
///
/// # Errors
/// As [`run`].
pub fn run_until<E: Experiment>(
    experiment: &E,
    options: &RunOptions<'_>,
    stop_sign: &AtomicBool,
    watch: &mut dyn FnMut(RunProgress),
) -> Result<Results<E::Record>, ExperimentError> {
    let is_stopped = || stop_sign.load(Ordering::Relaxed);
    let manifest = Manifest::of(experiment, options.seed)?;
    let cells = experiment.cells();
    let mut results = Results::new(cells.iter().map(|cell| cell.num_runs));
    let mut store = None;
    if let RunTarget::Folder(folder) = options.target {
        store = Some(Store::open(folder, &manifest, options.shard)?);
        read_records(experiment, &manifest, folder, &mut results)?;
    }
    let all = cells.iter().enumerate().flat_map(|(cell, c)| (0..c.num_runs).map(move |run| (cell, run)));
    let mine = (0..).zip(all).filter(|(place, _)| options.shard.contains(*place)).map(|(_, run)| run);
    let wanted: Vec<(usize, u64)> = mine.filter(|(cell, run)| !results.has(*cell, *run as usize)).collect();
    let seeds = RngTree::new(options.seed);
    let mut num_done = 0;
    watch(RunProgress { num_done, num_wanted: wanted.len() });
    for chunk in wanted.chunks((experiment.runs_per_thread() * rayon::current_num_threads()).max(1)) {
        let do_run =
            |(cell, run): &(usize, u64)| (!is_stopped()).then(|| experiment.run(*cell, *run, &seeds));
        let records: Vec<_> = chunk.par_iter().map(do_run).collect();
        for ((cell, run), record) in chunk.iter().zip(records) {
            let Some(record) = record else { continue };
            let record = record?;
            if let Some(store) = &mut store {
                store.append(&cells[*cell].label, *run, &record)?;
            }
            results.set(*cell, *run as usize, record);
        }
        num_done += chunk.len();
        watch(RunProgress { num_done, num_wanted: wanted.len() });
        if is_stopped() {
            break;
        }
    }
    Ok(results)
}
