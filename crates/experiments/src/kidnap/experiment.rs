//! Cells and runs.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use visloc_core::RngTree;

use super::contenders;
use crate::{
    Cell, Experiment, ExperimentError,
    positions::{Census, Contender, Scenario, Session},
};

/// Iterations before the position jumps.
pub(super) const KIDNAP_AFTER: usize = 200;
/// Iterations after that.
pub(super) const NUM_ITERATIONS_AFTER: usize = 200;
/// Least length of the jump, meters.
const MIN_JUMP_M: f64 = 8.0;
/// Likelihood far from the position.
pub(super) const FLOOR: f64 = 0.01;

/// What decides the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KidnapSettings {
    /// The algorithms with their parameters.
    pub contenders: Vec<Contender>,
}

/// What one run found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct KidnapRecord {
    /// Whether more than half of the individuals were near the position just before it jumped.
    pub had_converged: bool,
    /// Iterations after the jump until more than half of the individuals were near the new position.
    pub recovered_after: Option<u32>,
    /// Iterations after the jump from which on the answer was near the new position until the end.
    pub answer_right_after: Option<u32>,
}

/// The synthetic kidnap test.
#[derive(Debug, Clone)]
pub struct KidnapExperiment {
    settings: KidnapSettings,
    cells: Vec<Cell>,
}

impl KidnapExperiment {
    /// The experiment with so many runs for each contender.
    pub fn new(num_runs: u64) -> Self {
        let contenders = contenders::all();
        let cells = contenders.iter().map(|contender| Cell { label: contender.label.clone(), num_runs });
        Self { cells: cells.collect(), settings: KidnapSettings { contenders } }
    }
}

/// The scenario of a run; all contenders meet the same.
pub(super) fn scenario(run: u64, seeds: &RngTree) -> Arc<Scenario> {
    Arc::new(Scenario::kidnap(KIDNAP_AFTER, MIN_JUMP_M, &mut seeds.stream("kidnap", run)))
}

impl Experiment for KidnapExperiment {
    type Settings = KidnapSettings;
    type Record = KidnapRecord;

    fn name(&self) -> &'static str {
        "kidnap"
    }

    fn settings(&self) -> &KidnapSettings {
        &self.settings
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<KidnapRecord, ExperimentError> {
        let contender = &self.settings.contenders[cell];
        let mut rng = seeds.stream(&self.cells[cell].label, run);
        let mut session = Session::new(contender, scenario(run, seeds), FLOOR)?;
        let mut census = Census::default();
        for _ in 0..KIDNAP_AFTER {
            session.step(&mut rng);
        }
        let is_majority = |session: &mut Session, census: &mut Census| {
            session.count(census);
            2 * census.counts()[0] as usize > contender.num_individuals
        };
        let had_converged = is_majority(&mut session, &mut census);
        let (mut recovered_after, mut answer_right_after) = (None, None);
        for iteration in 1..=NUM_ITERATIONS_AFTER {
            session.step(&mut rng);
            let iteration = u32::try_from(iteration).ok();
            if recovered_after.is_none() && is_majority(&mut session, &mut census) {
                recovered_after = iteration;
            }
            answer_right_after =
                if session.is_answer_near() { answer_right_after.or(iteration) } else { None };
        }
        Ok(KidnapRecord { had_converged, recovered_after, answer_right_after })
    }
}
