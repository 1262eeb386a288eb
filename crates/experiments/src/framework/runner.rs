//! Doing the runs.

use std::{
    panic::resume_unwind,
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, RecvTimeoutError, Sender},
    },
    thread,
    time::Duration,
};

use rayon::{ThreadPool, prelude::*};
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

/// How often the stop sign is looked at while runs are going on.
const GLANCE: Duration = Duration::from_millis(50);

/// A run: the place of its cell, and its number there.
type Run = (usize, u64);
/// What became of each of some runs; nothing of those that were not done.
type Outcomes<E> = Vec<Option<Result<<E as Experiment>::Record, ExperimentError>>>;

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
    let seeds = RngTree::new(options.seed);
    let do_runs = |runs: &[Run]| -> Option<Outcomes<E>> {
        Some(runs.par_iter().map(|(cell, run)| Some(experiment.run(*cell, *run, &seeds))).collect())
    };
    conduct(experiment, options, rayon::current_num_threads(), &do_runs, watch)
}

/// As [`run`], on this pool, until the sign is set. Runs that have begun then are left to themselves: their threads go on until they are
/// through or the program ends.
///
/// # Errors
/// As [`run`].
pub fn run_until<E: Experiment<Record: 'static> + Send + 'static>(
    experiment: &Arc<E>,
    options: &RunOptions<'_>,
    pool: &Arc<ThreadPool>,
    stop_sign: &Arc<AtomicBool>,
    watch: &mut dyn FnMut(RunProgress),
) -> Result<Results<E::Record>, ExperimentError> {
    let seeds = RngTree::new(options.seed);
    let is_stopped = || stop_sign.load(Ordering::Relaxed);
    let do_runs = |runs: &[Run]| -> Option<Outcomes<E>> {
        if is_stopped() {
            return None;
        }
        let mut outcomes: Outcomes<E> = runs.iter().map(|_| None).collect();
        let (experiment, pool, sign) = (Arc::clone(experiment), Arc::clone(pool), Arc::clone(stop_sign));
        let runs = runs.to_vec();
        let work = move |sender: Sender<(usize, Result<E::Record, ExperimentError>)>| {
            pool.install(|| {
                runs.par_iter().enumerate().for_each(|(place, (cell, run))| {
                    if !sign.load(Ordering::Relaxed) {
                        // Nobody listens any more after a stop.
                        let _ = sender.send((place, experiment.run(*cell, *run, &seeds)));
                    }
                });
            });
        };
        work_until(stop_sign, work, &mut |(place, outcome)| outcomes[place] = Some(outcome));
        Some(outcomes)
    };
    conduct(experiment.as_ref(), options, pool.current_num_threads(), &do_runs, watch)
}

/// Takes what `work` sends, in a thread of its own, until it is through or the sign is set; then it is left to itself.
pub fn work_until<T: Send + 'static>(
    stop_sign: &AtomicBool,
    work: impl FnOnce(Sender<T>) + Send + 'static,
    take: &mut dyn FnMut(T),
) {
    let (sender, receiver) = mpsc::channel();
    let worker = thread::spawn(move || work(sender));
    loop {
        match receiver.recv_timeout(GLANCE) {
            Ok(found) => take(found),
            Err(RecvTimeoutError::Timeout) if stop_sign.load(Ordering::Relaxed) => return,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return worker.join().unwrap_or_else(|panic| resume_unwind(panic));
            }
        }
    }
}

/// `do_runs` gives nothing when no more are to be done.
fn conduct<E: Experiment>(
    experiment: &E,
    options: &RunOptions<'_>,
    num_threads: usize,
    do_runs: &dyn Fn(&[Run]) -> Option<Outcomes<E>>,
    watch: &mut dyn FnMut(RunProgress),
) -> Result<Results<E::Record>, ExperimentError> {
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
    let wanted: Vec<Run> = mine.filter(|(cell, run)| !results.has(*cell, *run as usize)).collect();
    let mut num_done = 0;
    watch(RunProgress { num_done, num_wanted: wanted.len() });
    for chunk in wanted.chunks((experiment.runs_per_thread() * num_threads).max(1)) {
        let Some(outcomes) = do_runs(chunk) else { break };
        for ((cell, run), outcome) in chunk.iter().zip(outcomes) {
            let Some(outcome) = outcome else { continue };
            let record = outcome?;
            if let Some(store) = &mut store {
                store.append(&cells[*cell].label, *run, &record)?;
            }
            results.set(*cell, *run as usize, record);
        }
        num_done += chunk.len();
        watch(RunProgress { num_done, num_wanted: wanted.len() });
    }
    Ok(results)
}
