//! `visloc slam`.

use std::path::Path;

use crate::support::{Workspace, data_lines};

fn clip() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip").to_str().unwrap().to_owned()
}

#[test]
fn parameters_come_from_preset_file_and_options() {
    let workspace = Workspace::new();
    let clip = clip();
    let run = |options: &[&str]| {
        let base = ["slam", &clip, "--until", "45", "--trajectory", "t.tum"];
        workspace.must(&[&base[..], options].concat());
        workspace.read("t.tum")
    };
    let sdvl = run(&[]);
    assert!(!data_lines(&sdvl).is_empty(), "{sdvl}");
    assert_eq!(sdvl, run(&["--preset", "config4"]), "the same configuration by its number");
    workspace.write("sdvl.toml", &workspace.must(&["config", "show", "sdvl"]).stdout);
    assert_eq!(sdvl, run(&["--config", "sdvl.toml"]), "what is shown reads back");
    let orb = run(&["--preset", "orb-sdvl"]);
    assert_ne!(sdvl, orb);
    assert_eq!(orb, run(&["--set", "features.descriptor=orb"]));
    workspace.write("few.toml", "[tracking]\nmax_matches = 60\n");
    let few = run(&["--config", "few.toml"]);
    assert_ne!(sdvl, few);
    assert_eq!(sdvl, run(&["--config", "few.toml", "--set", "tracking.max_matches = 250"]));
    assert_eq!(few, run(&["--set", "tracking.max_matches=60"]));
}

#[test]
fn mistakes_in_parameters_are_named() {
    let workspace = Workspace::new();
    let clip = clip();
    let refused = |options: &[&str]| workspace.refused(&[&["slam", &clip][..], options].concat());
    let error = refused(&["--preset", "svdl"]);
    assert!(error.contains("'svdl'") && error.contains("orb-sdvl"), "{error}");
    workspace.write("a.toml", "\n[tracking]\nmax_machtes = 3\n");
    let error = refused(&["--config", "a.toml"]);
    let wanted = "line 3: unknown key `max_machtes` in [tracking], did you mean `max_matches`?";
    assert!(error.contains("a.toml") && error.contains(wanted), "{error}");
    workspace.write("b.toml", "[mapping]\nlost_ratio = 1.5\n");
    let error = refused(&["--config", "b.toml"]);
    assert!(error.contains("line 2: mapping.lost_ratio: expected 0 to 1, found 1.5"), "{error}");
    let error = refused(&["--set", "mapping.adjust_bundels=false"]);
    assert!(error.contains("did you mean `adjust_bundles`?"), "{error}");
    let error = refused(&["--set", "features.descriptor=sift"]);
    assert!(error.contains("--set features.descriptor=sift") && error.contains("orb"), "{error}");
    let error = refused(&["--set", "tracking.max_matches=0"]);
    assert!(error.contains("--set tracking.max_matches=0: tracking.max_matches: expected 4 to"), "{error}");
    let error = workspace.refused(&["localize", "sim:still", "--frames", "2", "--set", "num_exploiters=-1"]);
    assert!(error.contains("found -1") && !error.contains("line"), "{error}");
    let error = refused(&["--set", "tracking.max_matches"]);
    assert!(error.contains("KEY=VALUE"), "{error}");
    let error = workspace.refused(&["config", "show", "sdlv"]);
    assert!(error.contains("sdlv") && error.contains("orb-sdvl"), "{error}");
}

/// The clip with nothing that tells where the camera was.
fn clip_without_truth(workspace: &Workspace) {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
            if entry.file_type().unwrap().is_dir() {
                copy(&entry.path(), &to.join(entry.file_name()));
            } else if !entry.file_name().to_string_lossy().contains("groundtruth") {
                std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
            }
        }
    }
    copy(Path::new(&clip()), &workspace.path("clip"));
}

#[test]
fn without_truth_the_way_and_the_map_are_drawn_and_written() {
    let workspace = Workspace::new();
    clip_without_truth(&workspace);
    let output = ["--plots", "plots", "--map", "map.ply", "--json", "r.json"];
    let text = workspace.must(&[&["slam", "clip"][..], &output].concat()).stdout;
    assert!(text.contains("pictures: plots") && text.contains("landmarks: map.ply"), "{text}");
    let report = workspace.json("r.json");
    assert!(report["ate_m"].is_null(), "{report}");
    for name in ["trajectory", "trajectory-side"] {
        assert!(workspace.path("plots").join(format!("{name}.png")).exists());
        let svg = workspace.read(&format!("plots/{name}.svg"));
        assert!(svg.contains("[map units]") && svg.contains("camera") && svg.contains("landmarks"));
    }
    let frame = workspace.read("plots/frame-00050.svg");
    assert!(frame.contains("tracked well") && !frame.contains("Tracking("), "plain words");
    assert_map(&workspace.read("map.ply"), &report);
}

/// Reads the map back: landmarks in gray, keyframes in another color, and edges between existing vertices.
fn assert_map(ply: &str, report: &serde_json::Value) {
    let (head, body) = ply.split_once("end_header\n").unwrap();
    let count = |element: &str| -> usize {
        let line = head.lines().find_map(|line| line.strip_prefix(&format!("element {element} ")));
        line.unwrap().parse().unwrap()
    };
    let rows: Vec<Vec<f64>> =
        body.lines().map(|line| line.split(' ').map(|value| value.parse().unwrap()).collect()).collect();
    let (points, keyframes) = (report["points"].as_u64().unwrap(), report["keyframes"].as_u64().unwrap());
    let (points, keyframes) = (points as usize, keyframes as usize);
    assert_eq!((count("vertex"), count("edge")), (points + 5 * keyframes, 8 * keyframes));
    let (vertices, edges) = rows.split_at(count("vertex"));
    assert_eq!(edges.len(), count("edge"));
    assert!(vertices.iter().all(|row| row.len() == 7) && edges.iter().all(|row| row.len() == 5));
    let is_gray = |row: &&Vec<f64>| row[3] == row[4] && row[4] == row[5];
    assert_eq!(vertices.iter().filter(is_gray).count(), points);
    let grays: std::collections::BTreeSet<u8> = vertices[..points].iter().map(|row| row[3] as u8).collect();
    assert!(grays.len() > 20, "the map has the grays of the images: {grays:?}");
    assert!(edges.iter().all(|row| (points..count("vertex")).contains(&(row[0] as usize))));
    assert!(vertices[points][..3].iter().all(|value| value.abs() < 1e-6), "the first keyframe is the origin");
}
