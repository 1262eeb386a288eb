//! Cells and runs.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use visloc_core::RngTree;

use super::contenders::{self, EXPLORERS, FILTERS, PARTICLES};
use crate::{
    Cell, Experiment, ExperimentError,
    positions::{Census, Contender, Movement, Scenario, ScenarioShape, Session},
};

/// Numbers of positions of the published tables.
pub(super) const POSITIONS: [usize; 3] = [2, 3, 4];
/// Iterations of the published experiment: 10 s at 30 images a second.
pub(super) const NUM_ITERATIONS: usize = 300;
/// Iterations of the long part.
pub(super) const NUM_LONG_ITERATIONS: usize = 3000;
/// Numbers of positions of the long part.
pub(super) const LONG_POSITIONS: [usize; 5] = [2, 3, 4, 6, 8];
/// How positions move in the long part.
pub(super) const LONG_MOVEMENTS: [Movement; 3] =
    [Movement::Static, Movement::Wandering(0.01), Movement::Wandering(0.05)];

/// Which runs are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SymmetryPart {
    /// The published tables.
    Published,
    /// Ten times as long, up to eight positions, at most 120 individuals.
    Long,
}

/// What decides the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SymmetrySettings {
    /// Which runs are done.
    pub part: SymmetryPart,
    /// The conditions.
    pub conditions: Vec<Condition>,
}

/// A contender in a world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// The algorithm with its parameters.
    pub contender: Contender,
    /// The world.
    pub shape: ScenarioShape,
}

impl Condition {
    fn label(&self) -> String {
        let Contender { label, num_individuals, .. } = &self.contender;
        format!("{label}, {num_individuals} individuals, {}", scenario_label(&self.shape))
    }
}

/// Names a scenario, and the streams that it is drawn from: all contenders meet the same scenarios.
fn scenario_label(shape: &ScenarioShape) -> String {
    let movement = match shape.movement {
        Movement::Static => "static".to_owned(),
        Movement::Straight(step_m) => format!("straight {step_m} m"),
        Movement::Wandering(step_m) => format!("wandering {step_m} m"),
    };
    format!("{} positions {movement}", shape.num_positions)
}

/// What one run found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SymmetryRecord {
    /// Individuals near each position at the end.
    pub counts: Vec<u32>,
    /// The first iteration, from 1, after which somebody was near every position; not looked for in particle filters,
    /// which begin with somebody everywhere.
    pub found_after: Option<u32>,
    /// Iterations after the published 300 in which some position was not held by the strict criterion.
    pub num_lost: u32,
}

impl SymmetryRecord {
    /// Whether all positions were held at the end by the strict criterion.
    pub fn holds_strictly(&self, num_individuals: usize) -> bool {
        Census::of(self.counts.clone()).holds_all_strictly(num_individuals)
    }
}

/// The symmetry experiment.
#[derive(Debug, Clone)]
pub struct SymmetryExperiment {
    settings: SymmetrySettings,
    cells: Vec<Cell>,
}

impl SymmetryExperiment {
    /// A part of the experiment with so many runs in each cell.
    pub fn new(part: SymmetryPart, num_runs: u64) -> Self {
        let conditions = match part {
            SymmetryPart::Published => published_conditions(),
            SymmetryPart::Long => long_conditions(),
        };
        let cells = conditions.iter().map(|condition| Cell { label: condition.label(), num_runs }).collect();
        Self { settings: SymmetrySettings { part, conditions }, cells }
    }

    /// The contender and the world of every cell.
    pub fn conditions(&self) -> &[Condition] {
        &self.settings.conditions
    }
}

fn published_conditions() -> Vec<Condition> {
    let mut conditions = Vec::new();
    let mut add = |contender: &Contender, movement| {
        for num_positions in POSITIONS {
            let shape = ScenarioShape { num_positions, movement, num_iterations: NUM_ITERATIONS };
            conditions.push(Condition { contender: contender.clone(), shape });
        }
    };
    for num_particles in PARTICLES {
        for filter in &FILTERS {
            add(&contenders::filter(filter, num_particles), Movement::Static);
        }
        add(&contenders::control(num_particles), Movement::Static);
    }
    let moving = Movement::Straight(0.01);
    for filter in &FILTERS {
        add(&contenders::filter(filter, 1000), moving);
    }
    add(&contenders::control(1000), moving);
    add(&contenders::evolutionary(20), moving);
    for num_explorers in EXPLORERS {
        add(&contenders::evolutionary(num_explorers), Movement::Static);
    }
    conditions
}

fn long_conditions() -> Vec<Condition> {
    let mut conditions = Vec::new();
    for contender in [contenders::evolutionary_long(), contenders::control(120)] {
        for movement in LONG_MOVEMENTS {
            for num_positions in LONG_POSITIONS {
                let shape = ScenarioShape { num_positions, movement, num_iterations: NUM_LONG_ITERATIONS };
                conditions.push(Condition { contender: contender.clone(), shape });
            }
        }
    }
    conditions
}

/// The scenario of a run.
pub(super) fn scenario(shape: &ScenarioShape, run: u64, seeds: &RngTree) -> Arc<Scenario> {
    Arc::new(Scenario::draw(shape, &mut seeds.stream(&scenario_label(shape), run)))
}

impl Experiment for SymmetryExperiment {
    type Settings = SymmetrySettings;
    type Record = SymmetryRecord;

    fn name(&self) -> &'static str {
        "symmetry"
    }

    fn settings(&self) -> &SymmetrySettings {
        &self.settings
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<SymmetryRecord, ExperimentError> {
        let Condition { contender, shape } = &self.settings.conditions[cell];
        let mut rng = seeds.stream(&self.cells[cell].label, run);
        let mut session = Session::new(contender, scenario(shape, run, seeds), 0.0)?;
        let is_watched = contender.algorithm == "evolutionary";
        let mut census = Census::default();
        let mut record = SymmetryRecord { counts: Vec::new(), found_after: None, num_lost: 0 };
        for iteration in 1..=shape.num_iterations {
            session.step(&mut rng);
            let is_late = iteration > NUM_ITERATIONS;
            let is_search = is_watched && record.found_after.is_none();
            if !(is_search || is_late || iteration == shape.num_iterations) {
                continue;
            }
            session.count(&mut census);
            if is_search && census.holds_all() {
                record.found_after = u32::try_from(iteration).ok();
            }
            record.num_lost += u32::from(is_late && !census.holds_all_strictly(contender.num_individuals));
        }
        record.counts = census.counts().to_vec();
        Ok(record)
    }
}
