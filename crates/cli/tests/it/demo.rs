//! `visloc demo` with few frames.

use std::fs;

use crate::support::Workspace;

#[test]
fn every_file_is_there_and_threads_change_nothing() {
    let workspace = Workspace::new();
    for (folder, threads) in [("one", "1"), ("two", "2")] {
        let outcome = workspace.must(&["demo", "--frames", "25", "--out", folder, "--threads", threads]);
        assert!(outcome.stdout.contains("evolutionary") && outcome.stdout.contains("Next:"));
        assert!(!outcome.stdout.contains('\u{1b}'), "no terminal codes in a pipe");
    }
    let pictures = ["trajectories", "errors", "individuals", "analysis"];
    let pictures = pictures.iter().flat_map(|name| [format!("{name}.svg"), format!("{name}.png")]);
    let tables = ["evolutionary.tum", "evolutionary.csv", "mcae.tum", "mcae.csv", "truth.tum"];
    for name in pictures.chain(tables.map(str::to_owned)) {
        let read = |folder: &str| fs::read(workspace.path(folder).join(&name)).unwrap();
        assert!(!read("one").is_empty());
        assert!(read("one") == read("two"), "{name} differs");
    }
    let summary = workspace.json("one/summary.json");
    assert_eq!(summary["algorithms"].as_array().unwrap().len(), 2);
    assert_eq!(summary["algorithms"][0]["frames"], 25);
    assert!(summary["algorithms"][1]["iteration_ms"]["mean"].is_number());
}

#[test]
fn another_seed_is_another_walk() {
    let workspace = Workspace::new();
    for seed in ["1", "2"] {
        workspace.must(&["demo", "--frames", "5", "--out", seed, "--seed", seed, "--scenario", "tour"]);
    }
    assert_ne!(workspace.read("1/truth.tum"), workspace.read("2/truth.tum"));
}

#[test]
fn unknown_scenario_lists_the_known_ones() {
    let error = Workspace::new().refused(&["demo", "--scenario", "moon"]);
    assert!(error.contains("moon") && error.contains("kidnaps"), "{error}");
}
