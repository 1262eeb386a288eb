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

/// Seconds and words of a line such as `  28.0 s  evolutionary found it, 2.1 s after it was put down`.
fn event(line: &str) -> Option<(f64, &str)> {
    let (secs, text) = line.trim_start().split_once(" s  ")?;
    Some((secs.parse().ok()?, text))
}

#[test]
fn lines_are_in_order_and_their_numbers_agree() {
    let workspace = Workspace::new();
    let scenario = "duration_secs = 13.0\nframes_per_sec = 15.0\n[[motion]]\nwander.secs = 5.0\n\
                    [[motion]]\ncarry = { secs = 1.0, lift_m = 0.3, has_foot_signal = true }\n\
                    [[motion]]\nwander.secs = 7.0\n";
    workspace.write("early.toml", scenario);
    let text = workspace.must(&["demo", "--scenario", "early.toml", "--plots", "pictures"]).stdout;
    assert!(workspace.path("pictures/trajectories.png").exists(), "{text}");
    let (mut last_secs, mut down_secs, mut num_found) = (0.0, 0.0, 0);
    for (secs, words) in text.lines().filter_map(event) {
        assert!(secs >= last_secs, "{text}");
        last_secs = secs;
        if words.starts_with("put down") {
            down_secs = secs;
        }
        let Some((_, took)) = words.split_once("found it, ") else { continue };
        let took_secs: f64 = took.split(' ').next().unwrap().parse().unwrap();
        // Each number is rounded to a tenth.
        assert!((secs - down_secs - took_secs).abs() < 0.11, "{words}: {text}");
        num_found += 1;
    }
    assert!(num_found >= 3 && down_secs > 4.0, "{text}");
}
