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
