//! The cells of the experiment.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use visloc_core::RngTree;
use visloc_locate::markov::{CaseTables, Outcomes, Remedy, ViewDensities, ViewLikelihoods};

use super::{
    goalkeeper::{self, GoalkeeperRecord, Keeper},
    goalless::{self, Blindness, GoallessCell, GoallessRecord},
    stage::Stage,
    tables::Learned,
    walk::{self, WalkRecord},
};
use crate::{Cell, Experiment, ExperimentError};

/// Share of each row of the tables that goes to all cases alike.
const SOFT_SHARE: f64 = 0.03;

/// What decides the records.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct MarkovSettings {
    /// Captures in each state from which the tables are learned anew (source: section 4.2, 50). None: the tables that
    /// come with the program, learned in the same way.
    pub captures: Option<Captures>,
    /// A recording with truth on a field with the published goals, from which the tables are learned instead; states that it
    /// does not show keep what comes with the program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<PathBuf>,
}

/// Captures in the simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Captures {
    /// How many in each state.
    pub per_state: u64,
    /// Their seed.
    pub seed: u64,
}

/// What happens in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Task {
    Synthetic,
    Images(Reading),
    Goalkeeper(Keeper),
    Goalless(GoallessCell),
}

/// How a walk with pictures is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// The published tables and outcomes, which were measured on a robot without odometry; no remedy.
    Published,
    /// The published tables with the remedy, and outcomes for a robot that has odometry, as the simulated one does what
    /// it is told.
    Odometry,
    /// The same with densities in place of the tables.
    Densities,
}

/// What one run found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MarkovRecord {
    /// A walk along the edge.
    Walk(WalkRecord),
    /// A goalkeeper.
    Goalkeeper(GoalkeeperRecord),
    /// A recovery after observations without a goal.
    Goalless(GoallessRecord),
}

/// Markov localization on the published grid: walk, images, goalkeeper, observations without a goal.
pub struct MarkovExperiment {
    settings: MarkovSettings,
    pub(super) stage: Stage,
    learned: Learned,
    /// The learned tables, softened.
    pub(super) tables: CaseTables,
    cells: Vec<Cell>,
    pub(super) tasks: Vec<Task>,
}

impl MarkovExperiment {
    /// Builds the field and, if wanted, learns the tables, in parallel on the current pool of threads. Every cell gets `num_runs`
    /// runs; the documents have one walk each and do not say how many goalkeepers.
    ///
    /// # Errors
    /// If the field cannot be built, or the tables or the recording cannot be read.
    pub fn new(settings: MarkovSettings, num_runs: u64) -> Result<Self, ExperimentError> {
        let stage = Stage::new()?;
        let learned = match (&settings.recording, settings.captures) {
            (Some(recording), _) => Learned::from_recording(&stage, recording)?,
            (None, Some(captures)) => {
                let seeds = RngTree::new(captures.seed).subtree("markov-tables", 0);
                Learned::from_captures(&stage, captures.per_state, &seeds)?
            }
            (None, None) => Learned::shipped()?,
        };
        let tasks = tasks();
        let cells = tasks.iter().map(|task| Cell { label: label(task), num_runs }).collect();
        Ok(Self { settings, stage, tables: learned.cases.softened(SOFT_SHARE), learned, cells, tasks })
    }

    /// The learned tables, as plain shares of the captures.
    pub fn learned_tables(&self) -> &CaseTables {
        &self.learned.cases
    }

    /// Where the tables are from, if not from the program's own captures.
    pub(super) fn origin_of_tables(&self) -> Option<&str> {
        self.learned.origin.as_deref()
    }

    /// What the same captures teach without cases.
    pub fn learned_densities(&self) -> &ViewDensities {
        &self.learned.densities
    }
}

impl Experiment for MarkovExperiment {
    type Settings = MarkovSettings;
    type Record = MarkovRecord;

    fn name(&self) -> &'static str {
        "markov"
    }

    fn settings(&self) -> &MarkovSettings {
        &self.settings
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<MarkovRecord, ExperimentError> {
        let (stage, tables) = (&self.stage, &self.tables);
        Ok(match &self.tasks[cell] {
            Task::Synthetic => MarkovRecord::Walk(walk::synthetic(stage, tables, run, seeds)),
            Task::Images(reading) => {
                let (views, outcomes, remedy): (&dyn ViewLikelihoods, _, _) = match reading {
                    Reading::Published => (tables, Outcomes::published(), Remedy::none()),
                    Reading::Odometry => (tables, Outcomes::of_odometry(), Remedy::default()),
                    Reading::Densities => {
                        (&self.learned.densities, Outcomes::of_odometry(), Remedy::default())
                    }
                };
                MarkovRecord::Walk(walk::images(stage, views, outcomes, remedy, (run, seeds))?)
            }
            Task::Goalkeeper(keeper) => {
                MarkovRecord::Goalkeeper(goalkeeper::run(stage, tables, *keeper, run, seeds)?)
            }
            Task::Goalless(cell) => MarkovRecord::Goalless(goalless::run(stage, tables, cell, run, seeds)?),
        })
    }
}

fn tasks() -> Vec<Task> {
    let mut tasks = vec![
        Task::Synthetic,
        Task::Images(Reading::Published),
        Task::Images(Reading::Odometry),
        Task::Images(Reading::Densities),
        Task::Goalkeeper(Keeper::Published),
        Task::Goalkeeper(Keeper::Corrected),
    ];
    for blindness in [Blindness::LooksAway, Blindness::Hidden, Blindness::Carried] {
        for has_remedy in [false, true] {
            for num_without in [0, 5, 20, 60] {
                tasks.push(Task::Goalless(GoallessCell { blindness, num_without, has_remedy }));
            }
        }
    }
    tasks
}

fn label(task: &Task) -> String {
    match task {
        Task::Synthetic => "walk, synthetic".to_owned(),
        Task::Images(Reading::Published) => "walk, images, as published".to_owned(),
        Task::Images(Reading::Odometry) => "walk, images, outcomes of odometry".to_owned(),
        Task::Images(Reading::Densities) => "walk, images, densities".to_owned(),
        Task::Goalkeeper(Keeper::Published) => "goalkeeper, published".to_owned(),
        Task::Goalkeeper(Keeper::Corrected) => "goalkeeper, corrected".to_owned(),
        Task::Goalless(cell) => {
            let why = match cell.blindness {
                Blindness::LooksAway => "looks away",
                Blindness::Hidden => "hidden",
                Blindness::Carried => "hidden and carried",
            };
            let remedy = if cell.has_remedy { "remedy" } else { "no remedy" };
            format!("{why}, {} without a goal, {remedy}", cell.num_without)
        }
    }
}
