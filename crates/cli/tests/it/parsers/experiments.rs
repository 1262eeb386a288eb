//! Folders in which runs of experiments keep what they found.

use std::fs;

use serde_json::json;
use visloc_experiments::{
    Experiment, Manifest, merge,
    symmetry::{SymmetryExperiment, SymmetryPart},
};

use super::{choice, chosen, in_folder};

const SEED: u64 = 1;

fn experiment() -> SymmetryExperiment {
    SymmetryExperiment::new(SymmetryPart::Published, 2)
}

/// What such a folder belongs to.
pub fn manifest() -> String {
    let experiment = experiment();
    json!({ "experiment": experiment.name(), "seed": SEED, "settings": experiment.settings() }).to_string()
}

/// A manifest, and records of the cells.
pub fn seeds() -> Vec<Vec<u8>> {
    let record = |cell: &str, run: u64| {
        json!({ "cell": cell, "run": run, "record": { "counts": [400, 600], "found_after": null, "num_lost": 0 } }).to_string() + "\n"
    };
    let records: String = experiment()
        .cells()
        .iter()
        .flat_map(|cell| [record(&cell.label, 0), record(&cell.label, 1)])
        .collect();
    vec![chosen(0, manifest()), chosen(1, records)]
}

pub fn read(bytes: &[u8]) {
    let Some((form, rest)) = choice(bytes, 2) else { return };
    in_folder(|folder| {
        let good = manifest();
        let files: [&[u8]; 2] = if form == 0 { [rest, b""] } else { [good.as_bytes(), rest] };
        for (name, bytes) in ["experiment.json", "records.jsonl"].into_iter().zip(files) {
            fs::write(folder.join(name), bytes).unwrap();
        }
        let merged =
            Manifest::read(folder).and_then(|manifest| merge(&experiment(), manifest.seed, &[folder]));
        let _ = merged.map(|results| experiment().report(&results, SEED, &[]));
    });
}
