//! Folders with the results of benchmarks, and what rendered recordings say of themselves.

use std::{fs, path::Path};

use serde_json::{Value, json};
use visloc_cli::{report_again, sequence_in};

use super::{choice, chosen, in_folder};

/// What a run has found.
pub fn result(class: &str, contender: &str, seed: u64, figures: &Value) -> String {
    let key = json!({
        "program": "0.1.0 01234567", "class": class, "recording": "R1", "num_bytes": 1000, "contender": contender, "seed": seed,
        "words": ["localize", "R1.mcap", "--end", "10"], "is_timed": false,
    });
    let way = |x: f64| json!([[x, 0.0, 0.0], null, [x, 1.0, 0.5]]);
    json!({ "key": key, "figures": figures, "truth": way(0.0), "estimate": way(0.1) }).to_string()
}

/// Results of a benchmark and of an earlier one, a line for each; a recording's description.
pub fn seeds() -> Vec<Vec<u8>> {
    let figures =
        |error: f64| json!({ "position_m": error, "coverage": 0.9, "kidnaps_found": 1.0, "time_ms": 2.5 });
    let field = |seed, error| result("field, tour", "evolutionary", seed, &figures(error));
    let room = |error: f64| result("S1 room", "sdvl", 101, &json!({ "ate_m": error, "coverage": 0.6 }));
    vec![
        chosen(0, [field(101, 0.1), field(102, 0.2), room(0.5)].join("\n") + "\n\n" + &field(101, 0.3)),
        chosen(0, room(0.1) + "\n\n" + &room(0.2)),
        chosen(1, json!({ "sequence": "S1", "seed": 1 }).to_string()),
    ]
}

pub fn read(bytes: &[u8]) {
    let Some((form, rest)) = choice(bytes, 2) else { return };
    in_folder(|folder| {
        if form == 1 {
            fs::write(folder.join("meta.json"), rest).unwrap();
            let _ = sequence_in(folder);
            return;
        }
        let folders = ["now", "before"].map(|name| folder.join(name));
        let behind = rest.windows(2).position(|pair| pair == b"\n\n").unwrap_or(rest.len());
        let (now, before) = rest.split_at(behind);
        for (folder, results) in folders.iter().zip([now, before]) {
            write(&folder.join("cells"), results);
        }
        let _ = report_again(&folders[0], &folders[1]);
    });
}

/// A file for each line.
fn write(folder: &Path, results: &[u8]) {
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder).unwrap();
    let results = results.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    for (number, result) in results.enumerate() {
        fs::write(folder.join(format!("{number}.json")), result).unwrap();
    }
}
