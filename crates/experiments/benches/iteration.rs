//! Time of one iteration in the synthetic world: motion, weights, search, estimate and the next generation.

#![allow(missing_docs, clippy::unwrap_used)]

use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use visloc_core::RngTree;
use visloc_experiments::{
    positions::{Contender, Movement, Scenario, ScenarioShape, Session},
    symmetry::{SymmetryExperiment, SymmetryPart},
};

/// The same contenders as in the experiment, after they have settled.
fn iteration(c: &mut Criterion) {
    let experiment = SymmetryExperiment::new(SymmetryPart::Published, 1);
    let shape = ScenarioShape { num_positions: 4, movement: Movement::Static, num_iterations: 0 };
    let mut group = c.benchmark_group("iteration");
    for (label, num_individuals) in
        [("evolutionary, 20 explorers", 100), ("MC", 1000), ("MCE", 1000), ("MC systematic", 1000)]
    {
        let is_wanted =
            |contender: &&Contender| contender.label == label && contender.num_individuals == num_individuals;
        let mut contenders = experiment.conditions().iter().map(|condition| &condition.contender);
        let contender = contenders.find(is_wanted).unwrap();
        let mut rng = RngTree::new(1).stream("bench", 0);
        let scenario = Arc::new(Scenario::draw(&shape, &mut rng));
        let mut session = Session::new(contender, scenario, 0.0).unwrap();
        (0..200).for_each(|_| session.step(&mut rng));
        group.throughput(Throughput::Elements(num_individuals as u64));
        group.bench_function(format!("{label}, {num_individuals}"), |b| b.iter(|| session.step(&mut rng)));
    }
    group.finish();
}

criterion_group!(benches, iteration);
criterion_main!(benches);
