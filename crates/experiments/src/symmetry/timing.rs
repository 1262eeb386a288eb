//! How long an iteration takes. Not part of the records, which are the same on every machine.

use serde::Serialize;
use visloc_core::RngTree;

use super::{
    contenders::{self, EXPLOITERS, EXPLORERS, FILTERS, PARTICLES},
    experiment::scenario,
};
use crate::{
    ExperimentError,
    positions::{Contender, Movement, ScenarioShape, Session},
};

/// Iterations that are measured, and those before them.
const NUM_ITERATIONS: (usize, usize) = (200, 50);

/// Time of an iteration of a contender.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IterationTime {
    /// Table, row and column.
    pub(super) place: (&'static str, String, String),
    /// Mean, milliseconds.
    pub(super) mean_ms: f64,
}

/// Measures every contender of the published tables of times with two positions, one after the other on this thread.
/// `clock_ms` tells the time in milliseconds.
///
/// # Errors
/// If a contender cannot be built.
pub fn measure(seed: u64, clock_ms: &mut dyn FnMut() -> f64) -> Result<Vec<IterationTime>, ExperimentError> {
    let mut contenders = Vec::new();
    for filter in &FILTERS {
        for num in PARTICLES {
            let place = ("times", filter.label.to_owned(), num.to_string());
            contenders.push((place, contenders::filter(filter, num)));
        }
    }
    for num_exploiters in EXPLOITERS {
        for num_explorers in EXPLORERS {
            let place = ("evolutionary-times", num_exploiters.to_string(), explorers(num_explorers));
            contenders.push((place, contenders::evolutionary_of(num_exploiters, num_explorers)));
        }
    }
    let time =
        |(place, contender)| Ok(IterationTime { place, mean_ms: mean_ms(&contender, seed, clock_ms)? });
    contenders.into_iter().map(time).collect()
}

/// Name of a column.
pub(super) fn explorers(num: usize) -> String {
    format!("{num} explorer{}", if num == 1 { "" } else { "s" })
}

fn mean_ms(
    contender: &Contender,
    seed: u64,
    clock_ms: &mut dyn FnMut() -> f64,
) -> Result<f64, ExperimentError> {
    let (num_measured, num_before) = NUM_ITERATIONS;
    let num_iterations = num_before + num_measured;
    let shape = ScenarioShape { num_positions: 2, movement: Movement::Static, num_iterations };
    let seeds = RngTree::new(seed);
    let mut session = Session::new(contender, scenario(&shape, 0, &seeds), 0.0)?;
    let mut rng = seeds.stream("timing", 0);
    (0..num_before).for_each(|_| session.step(&mut rng));
    let start_ms = clock_ms();
    (0..num_measured).for_each(|_| session.step(&mut rng));
    Ok((clock_ms() - start_ms) / num_measured as f64)
}
