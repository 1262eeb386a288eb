//! Every command explains itself.

use crate::support::Workspace;

#[test]
fn every_command_has_help_with_an_example() {
    let workspace = Workspace::new();
    for command in [
        "demo",
        "simulate",
        "localize",
        "locate",
        "slam",
        "record",
        "extract",
        "sources",
        "evaluate",
        "colors",
        "config",
        "map",
        "studio",
        "benchmark",
    ] {
        let help = workspace.must(&[command, "--help"]).stdout;
        assert!(help.contains("Usage: visloc"), "{command}: {help}");
        assert!(help.contains("Example") && help.contains(&format!("visloc {command}")), "{command}: {help}");
    }
    for command in ["demo", "simulate", "localize", "evaluate"] {
        let help = workspace.must(&[command, "--help"]).stdout;
        assert!(help.contains("--json"), "{command}: {help}");
        assert_eq!(help.contains("--seed"), command != "evaluate", "{command}: {help}");
    }
    assert!(workspace.must(&["--help"]).stdout.contains("visloc demo"));
}

#[test]
fn options_stand_below_the_heading_that_they_belong_to() {
    let workspace = Workspace::new();
    for (command, usual) in [
        (&["localize"][..], &["--trajectory", "--plots", "--team", "--overwrite", "--seed", "--json"][..]),
        (&["slam"], &["--save", "--points", "--json"]),
        (&["record"], &["--seed"]),
        (&["evaluate"], &["--json"]),
        (&["calibrate"], &["--model", "--out"]),
        (&["camera", "board"], &["--out"]),
    ] {
        let help = workspace.must(&[command, &["--help"]].concat()).stdout;
        let (_, options) = help.split_once("\nOptions:\n").unwrap();
        let end = ["Source:", "Topics:", "Board:", "For the studio:", "Cameras in space:"]
            .into_iter()
            .filter_map(|heading| options.find(&format!("\n{heading}\n")))
            .min();
        let options = &options[..end.unwrap()];
        for option in usual {
            assert!(
                options.split_whitespace().any(|word| word == *option),
                "{command:?} {option}: {options}"
            );
        }
    }
    assert!(workspace.must(&["experiment", "robocup", "--help"]).stdout.contains("unfelt (only the camera"));
}

#[test]
fn bad_usage_has_an_exit_code_of_its_own() {
    let workspace = Workspace::new();
    assert_eq!(workspace.visloc(&["localize"]).code, 2);
    assert_eq!(workspace.visloc(&["fly"]).code, 2);
    assert_eq!(workspace.visloc(&["demo", "--threads", "0"]).code, 2);
}

#[test]
fn lists() {
    let workspace = Workspace::new();
    assert!(workspace.must(&["algorithms"]).stdout.contains("evolutionary"));
    assert!(workspace.must(&["maps"]).stdout.contains("robocup-spl-2024"));
    assert!(workspace.must(&["simulate", "--list"]).stdout.contains("kidnaps"));
}
