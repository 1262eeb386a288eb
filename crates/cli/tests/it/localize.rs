//! `visloc localize` on good recordings.

use serde_json::Value;

use crate::support::{MAP, Workspace, data_lines, excerpt_text};

/// The keys that all commands share.
fn assert_shared_keys(report: &Value) {
    for key in ["position_error_m", "heading_error_deg"] {
        for part in ["mean", "median", "rmse", "p95", "max"] {
            assert!(report[key][part].is_number(), "{key}.{part} in {report}");
        }
    }
    for part in ["mean", "median", "p99", "max"] {
        assert!(report["iteration_ms"][part].is_number() && report["analysis_ms"][part].is_number());
    }
    assert!(report["frames"].is_u64() && report["kidnaps"].is_array());
    assert!(report["localized_share"].is_number() && report["time_to_localize_s"].is_number());
}

#[test]
fn a_walking_robot_is_found() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    for algorithm in ["evolutionary", "mce"] {
        let out = ["--trajectory", "r.tum", "--estimates", "r.csv", "--json", "r.json"];
        workspace.must(&[&["localize", &bag, "--map", MAP, "--algorithm", algorithm], &out[..]].concat());
        let report = workspace.json("r.json");
        assert_shared_keys(&report);
        assert_eq!(report["frames"], 90);
        assert_eq!(report["skipped"]["count"], 0);
        let median_m = report["position_error_m"]["median"].as_f64().unwrap();
        assert!(median_m < 0.3, "{algorithm}: {report}");
        assert_eq!(data_lines(&workspace.read("r.tum")).len(), 90);
        assert_eq!(workspace.read("r.csv").lines().count(), 91, "with its head");
    }
}

#[test]
fn a_kidnap_is_in_the_report() {
    let workspace = Workspace::new();
    workspace.must(&["localize", &excerpt_text("R2"), "--map", MAP, "--json", "r.json", "--plots", "plots"]);
    let report = workspace.json("r.json");
    assert_shared_keys(&report);
    let kidnaps = report["kidnaps"].as_array().unwrap();
    assert_eq!(kidnaps.len(), 1, "{report}");
    for key in ["time_s", "recovered", "recovery_s", "position_error_m"] {
        assert!(kidnaps[0].get(key).is_some(), "{key}");
    }
    for picture in ["trajectories.svg", "trajectories.png", "errors.png", "individuals.png", "analysis.png"] {
        assert!(workspace.path("plots").join(picture).exists(), "{picture}");
    }
}

/// As many particles as needed: many at the start, few as soon as the place is known.
#[test]
fn the_number_of_particles_and_the_reasons_of_the_analysis_are_reported() {
    let workspace = Workspace::new();
    let options = ["--map", MAP, "--algorithm", "kld", "--json", "r.json", "--estimates", "r.csv"];
    workspace.must(&[&["localize", &excerpt_text("R1")], &options[..]].concat());
    let report = workspace.json("r.json");
    let count = |key: &str| report["individuals"][key].as_u64().unwrap();
    assert_eq!((count("first"), count("max")), (3000, 3000));
    assert!(count("median") < 300, "{report}");
    assert!(
        workspace.read("r.csv").starts_with("t,x,y") && workspace.read("r.csv").contains(",individuals\n")
    );
    let dropped = report["pixels"]["dropped"].as_object().unwrap();
    assert_eq!(dropped.len(), 14, "every reason of every world is a key");
    assert!(report["pixels"]["kept"].as_u64().unwrap() > 500 && dropped["too thin"].is_u64(), "{report}");
}

#[test]
fn the_picture_of_the_analysis_can_be_chosen() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let base = ["localize", &bag, "--map", MAP, "--plots", "plots", "--picture-at", "1.5"];
    workspace.must(&base);
    assert!(workspace.read("plots/analysis.svg").contains("image at 1.5 s"));
    assert_eq!(workspace.visloc(&["localize", &bag, "--map", MAP, "--picture-at", "1"]).code, 2);
}

#[test]
fn without_truth_there_are_no_errors() {
    let workspace = Workspace::new();
    let options = ["--map", MAP, "--truth-topic", "", "--json", "r.json"];
    let outcome = workspace.must(&[&["localize", &excerpt_text("R1")], &options[..]].concat());
    assert!(outcome.stdout.contains("no truth"), "{}", outcome.stdout);
    let report = workspace.json("r.json");
    for key in ["position_error_m", "heading_error_deg", "localized_share", "time_to_localize_s", "kidnaps"] {
        assert!(report[key].is_null(), "{key}: {report}");
    }
    assert_eq!(report["frames"], 90);
    assert!(report["iteration_ms"]["mean"].is_number());
}

#[test]
fn the_truth_does_not_change_the_estimate() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    workspace.must(&["localize", &bag, "--map", MAP, "--estimates", "with.csv"]);
    workspace.must(&["localize", &bag, "--map", MAP, "--estimates", "without.csv", "--truth-topic", ""]);
    assert_eq!(workspace.read("with.csv"), workspace.read("without.csv"));
}

#[test]
fn a_scenario_in_place_of_a_bag() {
    let workspace = Workspace::new();
    let run = |seed: &str, threads: &str, file: &str| {
        let options = ["--frames", "20", "--seed", seed, "--threads", threads, "--estimates", file];
        workspace.must(&[&["localize", "sim:still"], &options[..]].concat());
        workspace.read(file)
    };
    let first = run("3", "1", "a.csv");
    assert_eq!(first, run("3", "2", "b.csv"), "threads change nothing");
    assert_ne!(first, run("4", "1", "c.csv"), "the seed does");
}

#[test]
fn a_simulated_bag_has_a_place_of_its_own() {
    let workspace = Workspace::new();
    workspace.must(&["simulate", "sim:still", "--frames", "3"]);
    assert!(workspace.path("out/still.mcap").exists());
    // Another name of the tour; the next command can be typed as it is printed.
    let said = workspace.must(&["simulate", "robocup", "--frames", "3", "--out", "my run/tour.mcap"]).stdout;
    assert!(said.contains("next: visloc localize 'my run/tour.mcap' --map robocup-spl-2010"), "{said}");
}

#[test]
fn a_simulated_bag_can_be_localized() {
    let workspace = Workspace::new();
    workspace
        .must(&["simulate", "still", "--out", "bag", "--frames", "30", "--seed", "2", "--json", "s.json"]);
    assert_eq!(workspace.json("s.json")["frames"], 30);
    assert!(workspace.path("bag/metadata.yaml").exists());
    assert_eq!(data_lines(&workspace.read("bag/truth.tum")).len(), 30);
    workspace.must(&["localize", "bag", "--map", MAP, "--json", "r.json", "--estimates", "r.csv"]);
    assert_eq!(workspace.json("r.json")["frames"], 30);
    workspace.must(&["evaluate", "bag/truth.tum", "r.csv", "--json", "e.json"]);
    let (localized, evaluated) = (workspace.json("r.json"), workspace.json("e.json"));
    assert_eq!(localized["localized_share"], evaluated["localized_share"]);
}

#[test]
fn the_ground_in_the_images_tells_the_motion_without_odometry() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let base = ["localize", &bag, "--map", MAP, "--json"];
    let run = |file: &str, options: &[&str]| {
        workspace.must(&[&base[..], &[file], options].concat());
        workspace.read(file)
    };
    let blind = run("blind.json", &["--odometry-topic", ""]);
    let seeing = run("seeing.json", &["--visual-odometry"]);
    assert_ne!(blind, seeing);
    let report = workspace.json("seeing.json");
    let error_m = report["position_error_m"]["mean"].as_f64().unwrap();
    assert!(error_m < 0.05, "{error_m}");
    let error = workspace
        .visloc(&[&base[..], &["a.json", "--visual-odometry", "--odometry-topic", "/odom"]].concat());
    assert!(error.code == 2 && error.stderr.contains("cannot be used with"), "{}", error.stderr);
}
