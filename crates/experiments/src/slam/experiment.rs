//! Cells and runs.

use serde::{Deserialize, Serialize};
use visloc_core::{Clock, RngTree, SkippedInput};
use visloc_plot::Picture;
use visloc_slam::SlamConfig;

use super::{
    follow::{SlamRunRecord, follow},
    map_pictures,
    pictures::file_name,
    sequence::{SlamSequence, open, short_name},
};
use crate::{Cell, Experiment, ExperimentError, Results};

/// Which question is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlamStudy {
    /// What bundle adjustment, outlier rejection and descriptors are worth. Source: 2017 section 7.1.
    Configs,
    /// What share of lost points should ask for a keyframe. Source: 2017 section 7.1.1, figure 7.3.
    LostPoints,
    /// What moving things do, with and without outlier rejection. Source: 2017 section 7.1.3.
    Dynamic,
    /// How a camera that was covered and carried away is found. Source: 2017 section 7.1.4.
    Kidnap,
    /// Beside the figures of other programs. Source: 2017 section 7.2.
    Compare,
}

impl SlamStudy {
    /// On the command line and in folders.
    pub fn name(self) -> &'static str {
        match self {
            Self::Configs => "slam-configs",
            Self::LostPoints => "slam-lost-points",
            Self::Dynamic => "slam-dynamic",
            Self::Kidnap => "slam-kidnap",
            Self::Compare => "slam-compare",
        }
    }

    /// Simulated sequences that need no files.
    pub fn usual_sequences(self) -> Vec<String> {
        let names: &[&str] = match self {
            Self::Configs | Self::LostPoints => &["sim:room"],
            Self::Dynamic => &["sim:walking"],
            Self::Kidnap => &["sim:kidnap"],
            Self::Compare => &["sim:room", "sim:hall"],
        };
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    /// Names of the configurations that are compared.
    pub fn configurations(self) -> Vec<String> {
        let names: &[&str] = match self {
            Self::Configs => &ALL,
            Self::LostPoints => &THRESHOLDS,
            Self::Dynamic => &DYNAMIC,
            Self::Kidnap | Self::Compare => &NAMED,
        };
        names.iter().map(|name| (*name).to_owned()).collect()
    }
}

/// The configurations of the thesis, and those with a name of their own.
const ALL: [&str; 8] =
    ["config1", "config2", "config3", "config4", "config5", "config6", "config7", "config8"];
const NAMED: [&str; 2] = ["sdvl", "orb-sdvl"];

/// Shares of lost points.
const THRESHOLDS: [&str; 9] = ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9"];
/// What comes after the name of a configuration without robust weights.
const NO_WEIGHTS: &str = ", no robust weights";
/// The published two, and the same without the robust weights, which the thesis does not have.
const DYNAMIC: [&str; 4] = ["config1", "config2", "config1, no robust weights", "config2, no robust weights"];

/// Parameters by the name of a configuration.
fn configuration(study: SlamStudy, name: &str) -> Result<SlamConfig, String> {
    let preset = |name: &str| SlamConfig::preset(name).map_err(|error| error.to_string());
    if study == SlamStudy::LostPoints {
        // The rule of this program that asks for keyframes by the image's shift is off.
        let rule = format!("mapping.lost_ratio = {name}\nmapping.max_shift_ratio = 10.0");
        return preset("config8")?.with_toml(&rule).map_err(|error| error.to_string());
    }
    let mut config = preset(name.trim_end_matches(NO_WEIGHTS))?;
    config.tracking.robust_weights = !name.ends_with(NO_WEIGHTS);
    Ok(config)
}

/// What decides the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SlamSettings {
    /// The question.
    pub study: SlamStudy,
    /// Folders, or `sim:NAME`.
    pub sequences: Vec<String>,
    /// Names of configurations.
    pub configurations: Vec<String>,
    /// Images of each sequence at most.
    pub max_frames: usize,
}

impl SlamSettings {
    /// A question on some sequences, those of the simulator if there are none.
    pub fn new(study: SlamStudy, sequences: &[String]) -> Self {
        let sequences = if sequences.is_empty() { study.usual_sequences() } else { sequences.to_vec() };
        Self { study, sequences, configurations: study.configurations(), max_frames: usize::MAX }
    }
}

/// A question with its cells.
#[derive(Debug, Clone)]
pub struct SlamExperiment {
    settings: SlamSettings,
    cells: Vec<Cell>,
    clock: Clock,
    warnings: Vec<String>,
    skipped: Vec<SkippedInput>,
}

impl SlamExperiment {
    /// The experiment with so many runs for each sequence and configuration; the clock measures the times.
    ///
    /// # Errors
    /// If a sequence cannot be opened or a configuration does not exist.
    pub fn new(settings: SlamSettings, num_runs: u64, clock: Clock) -> Result<Self, ExperimentError> {
        let setup = |reason| ExperimentError::Setup { reason };
        ExperimentError::if_twice("sequences", &settings.sequences)?;
        ExperimentError::if_twice("configurations", &settings.configurations)?;
        let (mut cells, mut warnings, mut skipped) = (Vec::new(), Vec::new(), Vec::new());
        for sequence in &settings.sequences {
            let first = open(sequence, settings.max_frames).map_err(setup)?;
            warnings.extend(first.warnings);
            skipped.extend_from_slice(first.images.status().skipped);
            for name in &settings.configurations {
                configuration(settings.study, name).map_err(setup)?;
                cells.push(Cell { label: format!("{}, {name}", short_name(sequence)), num_runs });
            }
        }
        Ok(Self { settings, cells, clock, warnings, skipped })
    }

    /// What the user should know of the sequences.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Lines of the sequences' lists that cannot be used.
    pub fn skipped(&self) -> &[SkippedInput] {
        &self.skipped
    }

    /// Sequence and configuration of a cell.
    pub(super) fn parts(&self, cell: usize) -> (&str, &str) {
        let n = self.settings.configurations.len();
        (&self.settings.sequences[cell / n], &self.settings.configurations[cell % n])
    }
}

impl Experiment for SlamExperiment {
    type Settings = SlamSettings;
    type Record = SlamRunRecord;

    fn name(&self) -> &'static str {
        self.settings.study.name()
    }

    fn settings(&self) -> &SlamSettings {
        &self.settings
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn runs_per_thread(&self) -> usize {
        1
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<SlamRunRecord, ExperimentError> {
        let (sequence, name) = self.parts(cell);
        let refused = |reason| ExperimentError::Run { cell: self.cells[cell].label.clone(), run, reason };
        let config = configuration(self.settings.study, name).map_err(refused)?;
        let SlamSequence { mut images, truth, .. } =
            open(sequence, self.settings.max_frames).map_err(refused)?;
        let seed = seeds.stream_seed("slam", run);
        follow(images.as_mut(), truth.as_ref(), &config, seed, self.clock.clone()).map_err(refused)
    }

    fn pictures_of_runs(
        &self,
        _: &Results<SlamRunRecord>,
        _: u64,
    ) -> Result<Vec<(String, Picture)>, ExperimentError> {
        let mut pictures = Vec::new();
        if self.settings.study == SlamStudy::Configs {
            for sequence in &self.settings.sequences {
                let file = file_name(&short_name(sequence));
                pictures.extend(map_pictures::all(sequence, &file, self.settings.max_frames)?);
            }
        }
        Ok(pictures)
    }
}
