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
        let base = ["slam", &clip, "--end", "45", "--trajectory", "t.tum"];
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
    let error = refused(&["--set", "tracking.max_matches"]);
    assert!(error.contains("KEY=VALUE"), "{error}");
    let error = workspace.refused(&["config", "show", "sdlv"]);
    assert!(error.contains("sdlv") && error.contains("orb-sdvl"), "{error}");
}
