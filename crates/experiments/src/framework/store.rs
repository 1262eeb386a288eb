//! The folder in which runs keep what they found.

use std::{
    fs::{self, File},
    io::Write,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use visloc_core::files;

use super::{Experiment, ExperimentError, Results, Shard};

/// Most bytes of a file of records.
const MAX_RECORD_BYTES: u64 = 1 << 32;
const MANIFEST: &str = "experiment.json";

/// What a folder's records belong to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Name of the experiment.
    pub experiment: String,
    /// Seed of all runs.
    pub seed: u64,
    /// Everything else that decides the records.
    pub settings: serde_json::Value,
}

impl Manifest {
    pub(super) fn of<E: Experiment>(experiment: &E, seed: u64) -> Result<Self, ExperimentError> {
        let settings = serde_json::to_value(experiment.settings()).map_err(|error| {
            ExperimentError::Folder { path: experiment.name().into(), reason: error.to_string() }
        })?;
        Ok(Self { experiment: experiment.name().to_owned(), seed, settings })
    }

    /// Reads the manifest of a folder.
    ///
    /// # Errors
    /// If there is none or it is damaged.
    pub fn read(folder: &Path) -> Result<Self, ExperimentError> {
        let path = folder.join(MANIFEST);
        let text = files::read_text(&path).map_err(ExperimentError::file(&path))?;
        serde_json::from_str(&text)
            .map_err(|error| ExperimentError::Folder { path, reason: format!("not a manifest: {error}") })
    }

    fn check(&self, found: &Self, folder: &Path) -> Result<(), ExperimentError> {
        if self == found {
            return Ok(());
        }
        let reason = if self.experiment != found.experiment {
            format!("holds runs of experiment {:?}, not {:?}", found.experiment, self.experiment)
        } else if self.seed != found.seed {
            format!("holds runs with seed {}, not {}", found.seed, self.seed)
        } else {
            format!("holds runs with other settings; compare {MANIFEST}, or choose another folder")
        };
        Err(ExperimentError::Folder { path: folder.to_owned(), reason })
    }
}

/// One line of a file of records.
#[derive(Serialize, Deserialize)]
struct Line<R> {
    cell: String,
    run: u64,
    record: R,
}

/// A file of records that grows.
pub(super) struct Store {
    path: PathBuf,
    file: File,
}

impl Store {
    /// Opens the file of a part in a folder, which is made if missing and checked if there.
    pub fn open(folder: &Path, manifest: &Manifest, shard: Shard) -> Result<Self, ExperimentError> {
        fs::create_dir_all(folder).map_err(ExperimentError::file(folder))?;
        let path = folder.join(MANIFEST);
        if path.exists() {
            manifest.check(&Manifest::read(folder)?, folder)?;
        } else {
            let text = serde_json::to_string_pretty(manifest)
                .map_err(|error| ExperimentError::Folder { path: path.clone(), reason: error.to_string() })?;
            files::replace(&path, text + "\n").map_err(ExperimentError::file(&path))?;
        }
        let name = if shard.is_whole() {
            "records.jsonl".to_owned()
        } else {
            format!("records-{}.jsonl", shard.to_string().replace('/', "-of-"))
        };
        let path = folder.join(name);
        let mut file =
            File::options().create(true).append(true).open(&path).map_err(ExperimentError::file(&path))?;
        // A line that was cut off by an interruption must not swallow the next one.
        let is_cut = files::read(&path, MAX_RECORD_BYTES)
            .map_err(ExperimentError::file(&path))?
            .last()
            .is_some_and(|b| *b != b'\n');
        if is_cut {
            file.write_all(b"\n").map_err(ExperimentError::file(&path))?;
        }
        Ok(Self { path, file })
    }

    /// Appends a record; `cell` is the cell's label.
    pub fn append<R: Serialize>(&mut self, cell: &str, run: u64, record: &R) -> Result<(), ExperimentError> {
        let line = serde_json::to_string(&Line { cell: cell.to_owned(), run, record }).map_err(|error| {
            ExperimentError::Folder { path: self.path.clone(), reason: error.to_string() }
        })?;
        self.file.write_all((line + "\n").as_bytes()).map_err(ExperimentError::file(&self.path))
    }
}

/// Reads the records of all parts in a folder. Lines that were cut off, and cells that are not wanted, are left out.
pub(super) fn read_records<E: Experiment>(
    experiment: &E,
    manifest: &Manifest,
    folder: &Path,
    results: &mut Results<E::Record>,
) -> Result<(), ExperimentError> {
    manifest.check(&Manifest::read(folder)?, folder)?;
    for path in record_files(folder)? {
        let text = files::read(&path, MAX_RECORD_BYTES).map_err(ExperimentError::file(&path))?;
        let text = String::from_utf8_lossy(&text);
        for (i, line) in text.lines().enumerate() {
            let line: Line<E::Record> = match serde_json::from_str(line) {
                Ok(line) => line,
                Err(error) if error.is_eof() => continue,
                Err(error) => {
                    let reason = format!("line {}: not a record: {error}", i + 1);
                    return Err(ExperimentError::Folder { path, reason });
                }
            };
            let cell = experiment.cells().iter().position(|cell| cell.label == line.cell);
            if let (Some(cell), Ok(run)) = (cell, usize::try_from(line.run)) {
                results.set(cell, run, line.record);
            }
        }
    }
    Ok(())
}

/// Sorted, so that the order of the folder does not matter.
fn record_files(folder: &Path) -> Result<Vec<PathBuf>, ExperimentError> {
    let is_records = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        name.starts_with("records") && path.extension().is_some_and(|extension| extension == "jsonl")
    };
    let entries = fs::read_dir(folder).map_err(ExperimentError::file(folder))?;
    let mut paths = Vec::new();
    for entry in entries {
        paths.push(entry.map_err(ExperimentError::file(folder))?.path());
    }
    paths.retain(is_records);
    paths.sort();
    Ok(paths)
}
