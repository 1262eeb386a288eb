//! `visloc likelihood` and `visloc study`.

use crate::support::{MAP, Workspace, excerpt_text};

#[test]
fn a_view_gives_pictures_tables_and_numbers() {
    let workspace = Workspace::new();
    let options = ["--step", "0.3", "--out", "out", "--json", "numbers.json"];
    workspace.must(&[&["likelihood", "--view", "0.6,1.3,-30"], &options[..]].concat());
    for name in ["likelihood-map", "likelihood-surface", "likelihood-heading", "image"] {
        assert!(workspace.read(&format!("out/{name}.svg")).starts_with("<svg"));
        assert!(workspace.path(&format!("out/{name}.png")).exists());
    }
    assert!(workspace.read("out/likelihood-map.csv").lines().count() > 300);
    let numbers = workspace.json("numbers.json");
    assert!(numbers["maximum_error_m"].as_f64().unwrap() < 0.5);
    assert!((numbers["best_heading_at_place_deg"].as_f64().unwrap() + 30.0).abs() < 3.0);
}

#[test]
fn a_frame_of_a_recording_is_found_by_its_time() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let common = ["likelihood", &bag, "--map", MAP, "--step", "0.5", "--out", "out"];
    workspace.must(&[&common[..], &["--at", "0.4", "--heading", "truth"]].concat());
    let error = workspace.refused(&[&common[..], &["--at", "1000"]].concat());
    assert!(error.contains("1000") && error.contains("last frame"), "{error}");
    for place in [&common[..], &["likelihood", "--view", "0.6,1.3,-30"]] {
        let error = workspace.refused(&[place, &["--place", "100,100"]].concat());
        assert!(error.contains("--place 100,100: expected a place on the map"), "{error}");
    }
}

#[test]
fn senseless_views_are_refused() {
    let workspace = Workspace::new();
    for args in [
        &["likelihood"][..],
        &["likelihood", "--view", "1,2"],
        &["likelihood", "--view", "1,2,3", "--heading", "north"],
        &["likelihood", "--view", "1,2,3", "--step", "0"],
        &["study", "weather"],
    ] {
        assert_eq!(workspace.visloc(args).code, 2, "{args:?}");
    }
    workspace.refused(&["likelihood", "--view", "1,2,3", "--map", "no-such-map"]);
}

#[test]
fn a_study_prints_what_the_document_says_and_what_comes_out() {
    let workspace = Workspace::new();
    let outcome = workspace.must(&["study", "discrimination", "--out", "out", "--json", "numbers.json"]);
    assert!(outcome.stdout.contains("document") && outcome.stdout.contains("-30"), "{}", outcome.stdout);
    assert!(workspace.read("out/discrimination.csv").lines().count() > 5);
    assert!(workspace.path("out/discrimination-surface.png").exists());
    assert!(workspace.json("numbers.json")["maximum_error_true_heading_m"].as_f64().unwrap() < 0.3);
}
