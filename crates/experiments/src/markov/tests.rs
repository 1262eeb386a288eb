//! A few runs of each part; the full numbers are in the experiment's report.

use visloc_core::RngTree;

use super::{
    experiment::{Reading, Task},
    goalkeeper::Keeper,
    *,
};
use crate::{Experiment, RunOptions, RunTarget, Shard, run};

fn experiment(num_runs: u64) -> MarkovExperiment {
    MarkovExperiment::new(MarkovSettings::default(), num_runs).unwrap()
}

fn records(experiment: &MarkovExperiment, task: Task) -> Vec<MarkovRecord> {
    let cell = experiment.tasks.iter().position(|t| *t == task).unwrap();
    let seeds = RngTree::new(1);
    (0..experiment.cells()[cell].num_runs).map(|run| experiment.run(cell, run, &seeds).unwrap()).collect()
}

/// The tables that come with the program are those that the simulator gives, here for three states.
#[test]
fn shipped_tables_are_learned_from_the_simulator() {
    let experiment = experiment(1);
    let captures = Captures { per_state: 50, seed: 1 };
    for state in [0, 16, 371] {
        let seeds = RngTree::new(captures.seed).subtree("markov-tables", 0);
        let taken = tables::captures_of(&experiment.stage, state, captures.per_state, &seeds).unwrap();
        let limits = *experiment.learned_tables().limits();
        let learned = visloc_locate::markov::learn_tables(limits, 384, taken.into_iter());
        let pairs = learned.size(state).iter().zip(experiment.learned_tables().size(state));
        assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-3), "{state}: {pairs:?}");
        let pairs = learned.centroid(state).iter().zip(experiment.learned_tables().centroid(state));
        assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-3), "{state}: {pairs:?}");
    }
}

/// Ten walks for each reading: known at the wall; found by t = 4 from pictures mostly, and with densities always.
#[test]
fn walks_are_localized() {
    let experiment = experiment(10);
    let readings = [Reading::Published, Reading::Odometry, Reading::Densities];
    let (mut found, mut at_wall) = ([0; 3], 0);
    for (count, reading) in found.iter_mut().zip(readings) {
        for record in records(&experiment, Task::Images(reading)) {
            let MarkovRecord::Walk(walk) = record else { panic!("a walk") };
            assert!(
                reading == Reading::Densities || !walk.is_right_at(0),
                "one picture is not enough for cases"
            );
            at_wall += usize::from(walk.is_right_at(11));
            *count += usize::from((0..=4).any(|t| walk.is_right_at(t)));
        }
    }
    assert!(at_wall >= 24, "{at_wall} of 30 at the wall");
    assert!(found[0] >= 5 && found[1] >= 5 && found[2] == 10, "{found:?} of 10");
}

/// Five goalkeepers; four must end inside the tile.
#[test]
fn goalkeepers_reach_their_tile() {
    let experiment = experiment(5);
    let records = records(&experiment, Task::Goalkeeper(Keeper::Corrected));
    let is_good = |record: &&MarkovRecord| matches!(record, MarkovRecord::Goalkeeper(r) if r.is_in_tile && r.has_arrived);
    assert!(records.iter().filter(is_good).count() >= 4, "{records:?}");
}

/// With the remedy, recovery takes no longer after many observations without a goal; without it, it does.
#[test]
fn remedy_keeps_recovery_fast() {
    let experiment = experiment(10);
    for blindness in [Blindness::LooksAway, Blindness::Hidden, Blindness::Carried] {
        let mean = |num_without, has_remedy| {
            let cell = GoallessCell { blindness, num_without, has_remedy };
            let counts = records(&experiment, Task::Goalless(cell)).into_iter().map(|record| match record {
                MarkovRecord::Goalless(record) => record.num_to_recover.unwrap_or(10),
                _ => panic!("a recovery"),
            });
            counts.sum::<usize>()
        };
        assert!(mean(20, true) <= mean(0, true), "{blindness:?}");
        if blindness == Blindness::Hidden {
            assert!(mean(20, false) > mean(0, false) + 20);
        }
    }
}

#[test]
fn the_report_has_tables_and_pictures() {
    let experiment = experiment(1);
    let shard: Shard = "1/8".parse().unwrap();
    let options = RunOptions { seed: 1, shard, target: RunTarget::Memory };
    let results = run(&experiment, &options, &mut |_| {}).unwrap();
    let report = experiment.report(&results, 1);
    assert!(report.text().contains("missing") && report.tables.len() == 6);
    assert!(report.pictures.iter().any(|(name, _)| name == "belief-synthetic-t06"));
}
