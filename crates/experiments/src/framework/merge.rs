//! Putting parts together.

use std::path::Path;

use super::{
    Experiment, ExperimentError, Results,
    store::{Manifest, read_records},
};

/// All records of several folders, the parts of one experiment with one seed.
///
/// # Errors
/// If a folder cannot be read or holds something else.
pub fn merge<E: Experiment>(
    experiment: &E,
    seed: u64,
    folders: &[impl AsRef<Path>],
) -> Result<Results<E::Record>, ExperimentError> {
    let manifest = Manifest::of(experiment, seed)?;
    let mut results = Results::new(experiment.cells().iter().map(|cell| cell.num_runs));
    for folder in folders {
        read_records(experiment, &manifest, folder.as_ref(), &mut results)?;
    }
    Ok(results)
}
