//! Folders in which runs of experiments keep what they found.

use std::fs;

use serde_json::{Value, json};
use visloc_cli::merged;
use visloc_core::Clock;
use visloc_experiments::{
    Experiment,
    kidnap::KidnapExperiment,
    markov::{MarkovExperiment, MarkovSettings},
    office::{OfficeExperiment, OfficeSettings},
    robocup::{ContenderRecord, KidnapScore, RobocupExperiment, RobocupRecord, RobocupSet, RobocupSettings},
    slam::{SlamExperiment, SlamSettings, SlamStudy},
    symmetry::{SymmetryExperiment, SymmetryPart},
    team::{TeamExperiment, TeamSettings},
};

use super::{choice, chosen, in_folder};

const SEED: u64 = 1;
const NUM_RUNS: u64 = 2;

fn symmetry() -> SymmetryExperiment {
    SymmetryExperiment::new(SymmetryPart::Published, NUM_RUNS)
}

/// What such a folder belongs to.
pub fn manifest() -> String {
    manifest_of(&symmetry())
}

fn manifest_of<E: Experiment>(experiment: &E) -> String {
    json!({ "experiment": experiment.name(), "seed": SEED, "settings": experiment.settings() }).to_string()
}

const NUM_EXPERIMENTS: usize = 7;

thread_local! {
    static MANIFESTS: [String; NUM_EXPERIMENTS] = [
        manifest(),
        manifest_of(&KidnapExperiment::new(NUM_RUNS)),
        manifest_of(&MarkovExperiment::new(MarkovSettings::default(), NUM_RUNS).unwrap()),
        manifest_of(&RobocupExperiment::new(RobocupSettings::default(), NUM_RUNS).unwrap()),
        manifest_of(&OfficeExperiment::new(OfficeSettings::default(), NUM_RUNS).unwrap()),
        manifest_of(&TeamExperiment::new(TeamSettings::default(), NUM_RUNS)),
        {
            let settings = SlamSettings::new(SlamStudy::Configs, &["sim:room".to_owned()]);
            manifest_of(&SlamExperiment::new(settings, NUM_RUNS, Clock::still()).unwrap())
        },
    ];
}

/// Manifests, and records of the cells.
pub fn seeds() -> Vec<Vec<u8>> {
    let record = |cell: &str, run: u64| {
        json!({ "cell": cell, "run": run, "record": { "counts": [400, 600], "found_after": null, "num_lost": 0 } }).to_string() + "\n"
    };
    let records: String =
        symmetry().cells().iter().flat_map(|cell| [record(&cell.label, 0), record(&cell.label, 1)]).collect();
    let others = (1..).zip(other_records()).map(|(form, record)| chosen(form, record));
    let manifests = MANIFESTS.with(Clone::clone).map(|manifest| chosen(0, manifest));
    manifests.into_iter().chain([chosen(1, records)]).chain(others).collect()
}

/// Of the other experiments, in the order of [`MANIFESTS`].
fn other_records() -> Vec<String> {
    let in_cell =
        |cell: &str, record: Value| json!({ "cell": cell, "run": 0, "record": record }).to_string() + "\n";
    let walk = json!({ "walk": { "localized": [0, 32, null], "true_belief": [0.8, 0.7, 0.1], "beliefs": [[0.5, 0.5], [0.9, 0.1]] } });
    let keeper = json!({ "goalkeeper": { "error_m": 0.06, "heading_error_rad": 0.2, "is_in_tile": true, "has_arrived": true, "num_actions": 25 } });
    let robocup = RobocupRecord {
        simulation_seed: 1,
        frames: 100,
        truth: None,
        contenders: vec![ContenderRecord {
            contender: "mc".into(),
            kidnaps: vec![KidnapScore::default()],
            ..ContenderRecord::default()
        }],
    };
    let score = json!({ "right_after_secs": [5.6, null], "num_untied": 0, "num_dragged": 0, "right_share": 0.2, "alone_right_share": 0.0,
                        "wrong_share": 0.1, "alone_wrong_share": 0.0 });
    let statistics =
        json!({ "rmse": 3.0, "mean": 2.3, "median": 2.0, "std": 1.8, "min": 1.5, "max": 14.8, "sse": 490.9 });
    vec![
        in_cell(
            "evolutionary",
            json!({ "had_converged": true, "recovered_after": 6, "answer_right_after": null }),
        ),
        [
            in_cell("walk, synthetic", walk),
            in_cell("goalkeeper, corrected", keeper),
            in_cell(
                "looks away, 5 without a goal, no remedy",
                json!({ "goalless": { "num_to_recover": 1 } }),
            ),
        ]
        .concat(),
        in_cell(RobocupSet::ALL[0].name(), json!(robocup)),
        in_cell(
            "office-walk, mce",
            json!({ "error_m": 0.1, "error_deg": 1.0, "first_localized_secs": 3.0, "recovery_secs": [2.0, null], "changed_secs": [1.0, 2.0],
                    "told_secs": [null, 1.0], "true_among_hypotheses": 0.9, "max_hypotheses": 40 }),
        ),
        in_cell(
            "2 robots",
            json!([{ "name": "alone", "score": score, "bytes_per_sec": 874.0 }, { "name": "team", "score": score, "bytes_per_sec": 874.0 }]),
        ),
        in_cell(
            "sim:room, config1",
            json!({ "num_frames": 60, "coverage": 1.0, "ate_rmse_m": 0.003, "ate": statistics, "ate_max_m": 0.007, "jump_m": 0.004,
                    "rpe_rot_deg": 0.026, "tracking_ms": 2.3, "mapping_ms": 2.0, "keyframe_ms": [9.0, 10.2], "relocalization_ms": null,
                    "tracking": statistics, "mapping": statistics, "stages": [["start frame", statistics]], "image_ms": [[0.0, 3.0]],
                    "num_lost": 0, "found_after_secs": [], "path": [[0.0, 2.1]], "true_path": [[2.1, -0.005]] }),
        ),
    ]
}

/// A manifest, or records of one of the experiments.
pub fn read(bytes: &[u8]) {
    let Some((form, rest)) = choice(bytes, 1 + NUM_EXPERIMENTS) else { return };
    in_folder(|folder| {
        let good = MANIFESTS.with(|all| all[form.max(1) - 1].clone());
        let files: [&[u8]; 2] = if form == 0 { [rest, b""] } else { [good.as_bytes(), rest] };
        for (name, bytes) in ["experiment.json", "records.jsonl"].into_iter().zip(files) {
            fs::write(folder.join(name), bytes).unwrap();
        }
        let _ = merged(&[folder], Some(NUM_RUNS));
    });
}
