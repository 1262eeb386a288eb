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
