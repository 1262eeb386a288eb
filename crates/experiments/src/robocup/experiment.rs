//! Cells and runs.

use serde::{Deserialize, Serialize};
use visloc_core::{RngTree, Source};
use visloc_locate::{ALGORITHMS, Algorithm, FeatureChoice};

use super::{
    record::RobocupRecord,
    score::{score, truth_of, truth_trace},
    sets::{RobocupSet, RunLength},
    track::{Contender, Track},
};
use crate::{Cell, Experiment, ExperimentError};

/// What decides the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobocupSettings {
    /// The kinds of runs.
    pub sets: Vec<RobocupSet>,
    /// Names of the algorithms, with their default parameters.
    pub algorithms: Vec<String>,
    /// What the pose is computed from; every algorithm plays with each of them.
    pub features: Vec<FeatureChoice>,
    /// Length of the runs.
    pub length: RunLength,
}

impl Default for RobocupSettings {
    /// All sets, all algorithms with all features that the analysis finds, full length.
    fn default() -> Self {
        Self {
            sets: RobocupSet::ALL.to_vec(),
            algorithms: ALGORITHMS.iter().map(|algorithm| algorithm.name.to_owned()).collect(),
            features: vec![FeatureChoice::Rich],
            length: RunLength::FULL,
        }
    }
}

/// The RoboCup experiment: every cell is one kind of runs, and in every run all algorithms see the same frames.
#[derive(Debug, Clone)]
pub struct RobocupExperiment {
    settings: RobocupSettings,
    cells: Vec<Cell>,
}

impl RobocupExperiment {
    /// The experiment with so many runs of each kind.
    ///
    /// # Errors
    /// If there is no such algorithm.
    pub fn new(settings: RobocupSettings, num_runs: u64) -> Result<Self, ExperimentError> {
        ExperimentError::if_twice("algorithms", &settings.algorithms)?;
        for algorithm in &settings.algorithms {
            Algorithm::named(algorithm)?;
        }
        let cell = |set: &RobocupSet| Cell { label: set.name().to_owned(), num_runs };
        Ok(Self { cells: settings.sets.iter().map(cell).collect(), settings })
    }

    /// The players of a set: every algorithm with every choice of features, and where places have mirror images once more
    /// with the half given.
    pub(super) fn contenders(&self, set: RobocupSet) -> Vec<Contender> {
        let mut contenders = Vec::new();
        for features in &self.settings.features {
            for algorithm in &self.settings.algorithms {
                let label = match features {
                    FeatureChoice::Rich => algorithm.clone(),
                    FeatureChoice::Pixels => format!("{algorithm}, 20 pixels"),
                };
                contenders.push(Contender {
                    label,
                    algorithm: algorithm.clone(),
                    features: *features,
                    is_given_half: false,
                    may_be_mirrored: set.is_mirrored(),
                });
            }
        }
        if set.is_mirrored() {
            let given = |contender: &Contender| Contender {
                label: format!("{}, half given", contender.label),
                is_given_half: true,
                may_be_mirrored: false,
                ..contender.clone()
            };
            let given: Vec<Contender> = contenders.iter().map(given).collect();
            contenders.extend(given);
        }
        contenders
    }
}

impl Experiment for RobocupExperiment {
    type Settings = RobocupSettings;
    type Record = RobocupRecord;

    fn name(&self) -> &'static str {
        "robocup"
    }

    fn settings(&self) -> &RobocupSettings {
        &self.settings
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// A run takes half a minute.
    fn runs_per_thread(&self) -> usize {
        1
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<RobocupRecord, ExperimentError> {
        let set = self.settings.sets[cell];
        let failed = |reason: String| ExperimentError::Run { cell: set.name().to_owned(), run, reason };
        let simulation = set.simulation(self.settings.length, run, seeds);
        let (mut simulation, simulation_seed) = simulation.map_err(|error| failed(error.to_string()))?;
        let contenders = self.contenders(set);
        let rng = seeds.subtree("pipeline", run);
        let tracks: Result<Vec<Track>, _> =
            contenders.iter().map(|contender| Track::new(simulation.map(), contender, rng)).collect();
        let mut tracks = tracks.map_err(|error| failed(error.to_string()))?;
        let (mut truth, mut start) = (Vec::new(), None);
        while let Some(next) = simulation.next_item() {
            let next = next.map_err(|error| failed(error.to_string()))?;
            let (mut frame, Some(at)) = (next.frame, next.truth) else { continue };
            if !set.has_odometry() {
                frame.odometry = None;
            }
            let secs = frame.at.secs_since(*start.get_or_insert(frame.at));
            truth.push((secs, at));
            for track in &mut tracks {
                track.step(&frame, secs, &at);
            }
        }
        let is_first = run == 0;
        let trajectory = truth_of(&truth);
        Ok(RobocupRecord {
            simulation_seed,
            frames: truth.len(),
            contenders: tracks.iter().map(|track| score(track, &trajectory, is_first)).collect(),
            truth: is_first.then(|| truth_trace(&truth)),
        })
    }
}
