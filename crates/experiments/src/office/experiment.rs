//! Cells and runs.

use serde::{Deserialize, Serialize};
use visloc_core::RngTree;
use visloc_locate::Algorithm;
use visloc_plot::Picture;

use super::{
    place,
    walk::{Walk, follow},
};
use crate::{Cell, Experiment, ExperimentError, Results};

/// What decides the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OfficeSettings {
    /// Scenarios of the simulator by name, or recordings (.mcap) with `map.yaml` beside them.
    pub scenarios: Vec<String>,
    /// The algorithms, by name.
    pub algorithms: Vec<String>,
    /// Frames of each run at most.
    pub max_frames: usize,
}

impl Default for OfficeSettings {
    fn default() -> Self {
        let names = |names: &[&str]| names.iter().copied().map(str::to_owned).collect();
        Self {
            scenarios: names(&["office-walk", "office", "office-light", "office-large"]),
            algorithms: names(&["mce", "evolutionary"]),
            max_frames: 3600,
        }
    }
}

/// What one run found. Lengths in meters, times in seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OfficeRecord {
    /// Mean position error from the first localization on, wrong phases included; `None` if there was no localization.
    pub error_m: Option<f64>,
    /// Mean heading error of the same frames, degrees.
    pub error_deg: Option<f64>,
    /// From the start to the first localization.
    pub first_localized_secs: Option<f64>,
    /// For each kidnap, time until the answer was right and stayed so; `None` if it never was.
    pub recovery_secs: Vec<Option<f64>>,
    /// For each kidnap, time until the answer was relied on at another place than before, right or wrong; `None` if it never was.
    #[serde(default)]
    pub changed_secs: Vec<Option<f64>>,
    /// For each kidnap, time until nothing but the true place explained what was seen; `None` if others always did.
    pub told_secs: Vec<Option<f64>>,
    /// Share of the images on the ground, before the first localization, in which the true place was among the
    /// hypotheses; `None` if there were no such images.
    pub true_among_hypotheses: Option<f64>,
    /// Most hypotheses at a time.
    pub max_hypotheses: usize,
}

/// The office experiment.
#[derive(Debug, Clone)]
pub struct OfficeExperiment {
    settings: OfficeSettings,
    cells: Vec<Cell>,
}

impl OfficeExperiment {
    /// The experiment with so many runs for each scenario and algorithm.
    ///
    /// # Errors
    /// If a name is there twice, or no algorithm has it.
    pub fn new(settings: OfficeSettings, num_runs: u64) -> Result<Self, ExperimentError> {
        ExperimentError::if_twice("scenarios", &settings.scenarios)?;
        ExperimentError::if_twice("algorithms", &settings.algorithms)?;
        settings.algorithms.iter().try_for_each(|name| Algorithm::named(name).map(drop))?;
        let mut cells = Vec::new();
        for scenario in &settings.scenarios {
            for algorithm in &settings.algorithms {
                let label = format!("{}, {algorithm}", place::short_name(scenario));
                cells.push(Cell { label, num_runs });
            }
        }
        Ok(Self { settings, cells })
    }

    /// Scenario and algorithm of a cell.
    pub(super) fn walk(&self, cell: usize) -> Walk<'_> {
        let num_algorithms = self.settings.algorithms.len();
        Walk {
            scenario: &self.settings.scenarios[cell / num_algorithms],
            algorithm: &self.settings.algorithms[cell % num_algorithms],
            max_frames: self.settings.max_frames,
        }
    }
}

impl Experiment for OfficeExperiment {
    type Settings = OfficeSettings;
    type Record = OfficeRecord;

    fn name(&self) -> &'static str {
        "office"
    }

    fn settings(&self) -> &OfficeSettings {
        &self.settings
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<OfficeRecord, ExperimentError> {
        Ok(follow(&self.walk(cell), run, seeds)?.record())
    }

    fn pictures_of_runs(
        &self,
        _: &Results<OfficeRecord>,
        seed: u64,
    ) -> Result<Vec<(String, Picture)>, ExperimentError> {
        self.pictures(seed)
    }
}
