//! What an experiment is.

use serde::{Serialize, de::DeserializeOwned};
use visloc_core::RngTree;
use visloc_plot::Picture;

use super::Results;
use crate::ExperimentError;

/// Runs under the same conditions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    /// Names it; no two cells of an experiment share a label.
    pub label: String,
    /// How many runs it has.
    pub num_runs: u64,
}

/// Many runs under several conditions.
///
/// Law: [`Experiment::run`] is pure. The same settings, cell, run and seeds give the same record, whatever ran before
/// it and on whichever machine.
pub trait Experiment: Sync {
    /// Everything that decides the records, apart from the seed and the number of runs.
    type Settings: Serialize;
    /// What one run found.
    type Record: Serialize + DeserializeOwned + Send;

    /// Names the experiment.
    fn name(&self) -> &'static str;

    /// Everything that decides the records, apart from the seed and the number of runs. Records of other settings are
    /// never mixed with these.
    fn settings(&self) -> &Self::Settings;

    /// All conditions.
    fn cells(&self) -> &[Cell];

    /// Runs that each thread does between two times of writing. Long runs are written one by one.
    fn runs_per_thread(&self) -> usize {
        8
    }

    /// One run of the cell at this place of [`Experiment::cells`]. `seeds` is the same for all runs: streams are told apart
    /// by label and run, so that cells can share what they are to share.
    ///
    /// # Errors
    /// Whatever makes the run impossible; a run that finds nothing is a record.
    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<Self::Record, ExperimentError>;

    /// Pictures for which something is run again, so that they take minutes. They are no part of a report.
    ///
    /// # Errors
    /// If a run for a picture is impossible.
    fn pictures_of_runs(
        &self,
        _results: &Results<Self::Record>,
        _seed: u64,
    ) -> Result<Vec<(String, Picture)>, ExperimentError> {
        Ok(Vec::new())
    }
}
