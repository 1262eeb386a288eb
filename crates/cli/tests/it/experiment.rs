//! `visloc experiment`.

use crate::support::Workspace;

#[test]
fn parts_merge_to_the_whole_and_runs_are_not_done_twice() {
    let workspace = Workspace::new();
    let kidnap = ["experiment", "kidnap", "--runs", "4"];
    workspace.must(&[&kidnap[..], &["--out", "whole"]].concat());
    for (part, shard) in [("one", "1/2"), ("two", "2/2")] {
        workspace.must(&[&kidnap[..], &["--out", part, "--shard", shard]].concat());
    }
    workspace.must(&["experiment", "merge", "one", "two", "--runs", "4", "--out", "merged"]);
    for file in ["report.txt", "report.json", "kidnap.csv"] {
        assert_eq!(workspace.read(&format!("whole/{file}")), workspace.read(&format!("merged/{file}")));
    }
    let records = workspace.read("whole/records.jsonl");
    workspace.must(&[&kidnap[..], &["--out", "whole"]].concat());
    assert_eq!(workspace.read("whole/records.jsonl"), records);
}

#[test]
fn a_folder_of_other_runs_is_refused() {
    let workspace = Workspace::new();
    let kidnap = ["experiment", "kidnap", "--runs", "1", "--out", "out"];
    workspace.must(&kidnap);
    let error = workspace.refused(&[&kidnap[..], &["--seed", "2"]].concat());
    assert!(error.contains("out") && error.contains("seed 1"), "{error}");
    let outcome = workspace.visloc(&["experiment", "kidnap", "--shard", "3/2"]);
    assert!(outcome.code != 0 && outcome.stderr.contains("K/N"), "{}", outcome.stderr);
}

#[test]
fn what_makes_cells_of_one_name_is_refused() {
    let workspace = Workspace::new();
    for (words, what) in [
        ("office office-walk --algorithm mce --algorithm mce", "algorithms"),
        ("office office-walk office-walk", "scenarios"),
        ("robocup --algorithm mc --algorithm mc", "algorithms"),
        ("slam-configs sim:room sim:room", "sequences"),
    ] {
        let words: Vec<&str> = words.split(' ').collect();
        let error = workspace.refused(&[&["experiment"], &words[..]].concat());
        assert!(error.contains(what) && error.contains("each name once"), "{error}");
    }
}
