//! What the synthetic experiments show, with few runs. Seeds are fixed; the margins are far from what was measured.

#![allow(clippy::unwrap_used)]

use visloc_core::RngTree;
use visloc_experiments::{
    Experiment, RunOptions, RunTarget, Shard,
    kidnap::KidnapExperiment,
    run,
    symmetry::{SymmetryExperiment, SymmetryPart},
};

/// Places of the cells with this contender and as many positions.
fn cells(experiment: &SymmetryExperiment, label: &str, num_positions: usize) -> Vec<usize> {
    let is_wanted = |i: &usize| {
        let condition = &experiment.conditions()[*i];
        condition.contender.label.starts_with(label) && condition.shape.num_positions == num_positions
    };
    (0..experiment.conditions().len()).filter(is_wanted).collect()
}

#[test]
fn labels_of_cells_are_unique() {
    for part in [SymmetryPart::Published, SymmetryPart::Long] {
        let experiment = SymmetryExperiment::new(part, 1);
        let mut labels: Vec<&str> = experiment.cells().iter().map(|cell| cell.label.as_str()).collect();
        labels.sort_unstable();
        labels.dedup();
        assert_eq!(labels.len(), experiment.cells().len());
    }
}

#[test]
fn the_evolutionary_algorithm_keeps_eight_moving_positions_and_chance_does_not() {
    let experiment = SymmetryExperiment::new(SymmetryPart::Long, 1);
    let seeds = RngTree::new(1);
    for cell in cells(&experiment, "evolutionary", 8) {
        let record = experiment.run(cell, 0, &seeds).unwrap();
        assert!(record.num_lost == 0 && record.holds_strictly(120), "{record:?}");
    }
    for cell in cells(&experiment, "uniform", 8) {
        assert!(experiment.run(cell, 0, &seeds).unwrap().num_lost > 2000);
    }
}

#[test]
fn particles_that_know_nothing_meet_the_published_criterion_only() {
    let experiment = SymmetryExperiment::new(SymmetryPart::Published, 1);
    for cell in cells(&experiment, "uniform", 2) {
        let condition = &experiment.conditions()[cell];
        if condition.contender.num_individuals == 1000 {
            let record = experiment.run(cell, 0, &RngTree::new(1)).unwrap();
            assert!(record.counts.iter().all(|count| *count > 0) && !record.holds_strictly(1000));
        }
    }
}

#[test]
fn kidnapped_robots_are_found_except_by_the_classic_filter() {
    let experiment = KidnapExperiment::new(3);
    let options = RunOptions { seed: 1, shard: Shard::WHOLE, target: RunTarget::Memory };
    let results = run(&experiment, &options, &mut |_| ()).unwrap();
    for (cell, contender) in experiment.settings().contenders.iter().enumerate() {
        for record in results.cell(cell) {
            assert!(record.had_converged, "{}", contender.label);
            let is_found = record.recovered_after.is_some_and(|after| after <= 30);
            assert_eq!(is_found, contender.label != "MC, no recovery", "{}", contender.label);
        }
    }
}
