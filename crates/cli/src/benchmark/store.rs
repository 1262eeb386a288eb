//! What runs have found, one file for each.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use visloc_core::files;

use super::quantities::Quantity;

/// What tells a run from others. A file with another key is not taken for its result.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellKey {
    /// Version of the program, with a sum over its bytes.
    pub program: String,
    /// Class of the recording.
    pub class: String,
    /// Name of the recording.
    pub recording: String,
    /// Bytes of the recording.
    pub num_bytes: u64,
    /// Name of the settings.
    pub contender: String,
    /// The seed.
    pub seed: u64,
    /// The command that does the run, with path and options.
    pub words: Vec<String>,
    /// Whether times were measured, and not accuracy.
    pub is_timed: bool,
}

/// What a run has found.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Cell {
    /// Which run.
    pub key: CellKey,
    /// Its figures; what did not happen has none.
    pub figures: BTreeMap<Quantity, f64>,
    /// Some true places, and the estimated ones of the same times; `null` where there is none.
    #[serde(default)]
    pub truth: Vec<Option<[f64; 3]>>,
    /// See `truth`.
    #[serde(default)]
    pub estimate: Vec<Option<[f64; 3]>>,
}

/// A folder with results.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// In a folder for all of a benchmark.
    pub fn new(out: &Path) -> Self {
        Self { folder: out.join("cells") }
    }

    /// The result of a run, if it is there.
    pub fn find(&self, key: &CellKey) -> Option<Cell> {
        read(&self.path(key)).ok().filter(|cell| cell.key == *key)
    }

    /// Writes a result.
    pub fn add(&self, cell: &Cell) -> Result<()> {
        let (path, text) = (self.path(&cell.key), serde_json::to_string_pretty(cell)?);
        files::replace(&path, text + "\n").with_context(|| format!("{}: cannot write it", path.display()))
    }

    /// A file beside the results, for a program that writes its numbers.
    pub fn scratch(&self) -> PathBuf {
        self.folder.join("running.json")
    }

    /// All results that are there, of whatever program.
    pub fn all(&self) -> Result<Vec<Cell>> {
        let place = || format!("{}: expected the results of a benchmark", self.folder.display());
        let entries = fs::read_dir(&self.folder).with_context(place)?;
        let mut paths: Vec<PathBuf> = entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
        paths.retain(|path| {
            path.extension().is_some_and(|ending| ending == "json") && *path != self.scratch()
        });
        paths.sort();
        let cells: Vec<Cell> = paths.iter().map(|path| read(path)).collect::<Result<_>>()?;
        if cells.is_empty() {
            return Err(anyhow::anyhow!("{}, found none", place()));
        }
        Ok(cells)
    }

    /// The name tells people what it is and keeps runs apart.
    fn path(&self, key: &CellKey) -> PathBuf {
        let kind = if key.is_timed { "times" } else { "accuracy" };
        let text = format!("{} {} {} {kind}", key.recording, key.contender, key.seed);
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
        let name: String = text.chars().map(plain).take(120).collect();
        self.folder.join(format!("{name}-{:08x}.json", crc32fast::hash(key.words.join("\n").as_bytes())))
    }
}

fn read(path: &Path) -> Result<Cell> {
    let place = || path.display().to_string();
    let text = files::read_text(path).with_context(place)?;
    serde_json::from_str(&text).with_context(place)
}

/// Version of this program with a sum over its bytes: another build may compute something else.
pub fn program() -> String {
    let bytes = std::env::current_exe().and_then(|path| files::read(&path, 1 << 32)).unwrap_or_default();
    format!("{} {:08x}", env!("CARGO_PKG_VERSION"), crc32fast::hash(&bytes))
}
