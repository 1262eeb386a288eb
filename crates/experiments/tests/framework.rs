//! Runs are repeatable, resumable and can be done in parts.

#![allow(clippy::unwrap_used)]

use std::{
    fs,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread,
};

use rand::RngExt;
use visloc_core::RngTree;
use visloc_experiments::{
    Cell, Experiment, ExperimentError, RunOptions, RunProgress, RunTarget, Shard, merge, run, run_until,
};

/// Draws one number per run, and counts how often it was asked to.
struct Dice {
    cells: Vec<Cell>,
    faces: u32,
    num_rolled: AtomicUsize,
}

impl Dice {
    fn new(faces: u32) -> Self {
        let cell = |label: &str, num_runs| Cell { label: label.to_owned(), num_runs };
        Self { cells: vec![cell("red", 40), cell("blue", 25)], faces, num_rolled: AtomicUsize::new(0) }
    }

    fn num_rolled(&self) -> usize {
        self.num_rolled.load(Ordering::Relaxed)
    }
}

impl Experiment for Dice {
    type Settings = u32;
    type Record = u32;

    fn name(&self) -> &'static str {
        "dice"
    }

    fn settings(&self) -> &u32 {
        &self.faces
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<u32, ExperimentError> {
        self.num_rolled.fetch_add(1, Ordering::Relaxed);
        Ok(seeds.stream(&self.cells[cell].label, run).random_range(1..=self.faces))
    }
}

fn options<'a>(seed: u64, shard: &str, target: RunTarget<'a>) -> RunOptions<'a> {
    RunOptions { seed, shard: shard.parse().unwrap(), target }
}

fn whole(seed: u64) -> visloc_experiments::Results<u32> {
    run(&Dice::new(6), &options(seed, "1/1", RunTarget::Memory), &mut |_| ()).unwrap()
}

#[test]
fn the_same_seed_gives_the_same_results_on_any_number_of_threads() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(5).build().unwrap();
    assert_eq!(whole(3), pool.install(|| whole(3)));
    assert_ne!(whole(3), whole(4));
    assert_eq!((whole(3).num_runs(), whole(3).num_missing()), (65, 0));
}

#[test]
fn a_stopped_experiment_keeps_what_is_done_and_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let options = options(3, "1/1", RunTarget::Folder(folder.path()));
    let stop_sign = Arc::new(AtomicBool::new(false));
    let mut stop_soon = |done: RunProgress| {
        if done.num_done > 0 {
            stop_sign.store(true, Ordering::Relaxed);
        }
    };
    let dice = Arc::new(Dice::new(6));
    let part = run_until(&dice, &options, &two_threads(), &stop_sign, &mut stop_soon).unwrap();
    assert!(part.num_missing() > 0 && part.num_missing() < part.num_runs());
    assert_eq!(run(&Dice::new(6), &options, &mut |_| ()).unwrap(), whole(3));
}

fn two_threads() -> Arc<rayon::ThreadPool> {
    Arc::new(rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap())
}

/// Two runs that end at once, and two that give the stop sign and never end.
struct Endless {
    cells: [Cell; 2],
    stop_sign: Arc<AtomicBool>,
}

impl Experiment for Endless {
    type Settings = ();
    type Record = u64;

    fn name(&self) -> &'static str {
        "endless"
    }

    fn settings(&self) -> &() {
        &()
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn runs_per_thread(&self) -> usize {
        1
    }

    fn run(&self, cell: usize, run: u64, _: &RngTree) -> Result<u64, ExperimentError> {
        if cell == 0 {
            return Ok(run);
        }
        self.stop_sign.store(true, Ordering::Relaxed);
        loop {
            thread::park();
        }
    }
}

#[test]
fn runs_that_have_begun_are_not_waited_for() {
    let stop_sign = Arc::new(AtomicBool::new(false));
    let cells = ["short", "long"].map(|label| Cell { label: label.to_owned(), num_runs: 2 });
    let endless = Arc::new(Endless { cells, stop_sign: Arc::clone(&stop_sign) });
    let options = options(3, "1/1", RunTarget::Memory);
    let part = run_until(&endless, &options, &two_threads(), &stop_sign, &mut |_| ()).unwrap();
    assert_eq!((part.cell(0).copied().collect::<Vec<_>>(), part.num_missing()), (vec![0, 1], 2));
}

#[test]
fn parts_in_several_folders_merge_to_the_whole() {
    let folders: Vec<_> = (0..3).map(|_| tempfile::tempdir().unwrap()).collect();
    for (folder, shard) in folders.iter().zip(["1/3", "2/3", "3/3"]) {
        let target = RunTarget::Folder(folder.path());
        let part = run(&Dice::new(6), &options(3, shard, target), &mut |_| ()).unwrap();
        assert!(part.num_missing() > 40, "a third of the runs only");
    }
    assert_eq!(merge(&Dice::new(6), 3, &folders).unwrap(), whole(3));
}

#[test]
fn parts_may_share_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let target = RunTarget::Folder(folder.path());
    for shard in ["2/2", "1/2"] {
        run(&Dice::new(6), &options(3, shard, target), &mut |_| ()).unwrap();
    }
    assert_eq!(merge(&Dice::new(6), 3, &[folder.path()]).unwrap(), whole(3));
}

#[test]
fn an_interrupted_experiment_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let target = RunTarget::Folder(folder.path());
    run(&Dice::new(6), &options(3, "1/1", target), &mut |_| ()).unwrap();
    let path = folder.path().join("records.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() / 2]).unwrap(); // ends in the middle of a line
    let num_kept = text[..text.len() / 2].matches('\n').count();
    let again = Dice::new(6);
    let mut last = None;
    let results = run(&again, &options(3, "1/1", target), &mut |progress| last = Some(progress)).unwrap();
    assert_eq!(results, whole(3));
    assert_eq!(again.num_rolled(), 65 - num_kept);
    assert_eq!(last, Some(RunProgress { num_done: 65 - num_kept, num_wanted: 65 - num_kept }));
    let nothing_left = Dice::new(6);
    run(&nothing_left, &options(3, "1/1", target), &mut |_| ()).unwrap();
    assert_eq!(nothing_left.num_rolled(), 0);
}

#[test]
fn what_is_no_record_is_told() {
    let folder = tempfile::tempdir().unwrap();
    run(&Dice::new(6), &options(3, "1/1", RunTarget::Folder(folder.path())), &mut |_| ()).unwrap();
    let path = folder.path().join("records.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    for damage in ["hello", "{\"cell\": 1}", "[]"] {
        fs::write(&path, format!("{damage}\n{text}")).unwrap();
        let said = merge(&Dice::new(6), 3, &[folder.path()]).unwrap_err().to_string();
        assert!(said.contains("line 1: not a record"), "{said}");
    }
}

#[test]
fn a_folder_of_another_seed_or_other_settings_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let target = RunTarget::Folder(folder.path());
    run(&Dice::new(6), &options(3, "1/1", target), &mut |_| ()).unwrap();
    let refusal =
        |dice: &Dice, seed| run(dice, &options(seed, "1/1", target), &mut |_| ()).unwrap_err().to_string();
    assert!(refusal(&Dice::new(6), 4).contains("seed 3, not 4"));
    assert!(refusal(&Dice::new(8), 3).contains("other settings"));
    assert!(merge(&Dice::new(8), 3, &[folder.path()]).is_err());
}

#[test]
fn a_shard_is_written_as_it_is_read() {
    assert_eq!("2/8".parse::<Shard>().unwrap().to_string(), "2/8");
}
