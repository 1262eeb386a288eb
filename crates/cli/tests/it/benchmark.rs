//! `visloc benchmark`.

use std::{collections::BTreeMap, fs};

use serde_json::Value;

use crate::support::{MAP, Workspace};

/// A recording with its map, and one that is none.
fn recordings() -> Workspace {
    let workspace = Workspace::new();
    fs::create_dir_all(workspace.path("data/R1")).unwrap();
    workspace.bag("data/R1/R1.mcap", 45, |_, _| {});
    workspace.write("data/R1/map.toml", &workspace.must(&["map", "show", MAP]).stdout);
    workspace.write("data/broken.mcap", "no bag");
    workspace
}

const RUN: [&str; 7] = ["benchmark", "--data", "data", "--only", "R1", "--seeds", "1"];

/// All cells with what they hold, by name.
fn cells(workspace: &Workspace, out: &str) -> BTreeMap<String, Value> {
    let entries = fs::read_dir(workspace.path(&format!("{out}/cells"))).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.map(|name| (name.clone(), workspace.json(&format!("{out}/cells/{name}")))).collect()
}

fn is_accuracy(cell: &Value) -> bool {
    cell["key"]["is_timed"] == false
}

fn change(workspace: &Workspace, out: &str, change: impl Fn(&mut Value)) {
    for (name, mut cell) in cells(workspace, out) {
        if is_accuracy(&cell) {
            change(&mut cell);
            workspace.write(&format!("{out}/cells/{name}"), &cell.to_string());
        }
    }
}

#[test]
fn the_same_accuracy_twice_and_changes_are_named() {
    let workspace = recordings();
    let said = workspace.must(&[&RUN[..], &["--out", "one"]].concat()).stdout;
    assert!(said.contains("field, tour") && said.contains("0.142"), "{said}");
    assert!(said.contains("data/broken.mcap: "), "what cannot be used is listed: {said}");
    let first = cells(&workspace, "one");
    let accuracy = |cells: &BTreeMap<String, Value>| -> Vec<Value> {
        cells.values().filter(|cell| is_accuracy(cell)).cloned().collect()
    };
    assert!(accuracy(&first).len() >= 4 && accuracy(&first).len() < first.len(), "{:?}", first.keys());
    for cell in accuracy(&first) {
        let figure = |name: &str| cell["figures"][name].as_f64().unwrap();
        assert!((0.0..0.3).contains(&figure("claimed_position_m")), "{cell}");
        assert!(
            (0.0..0.1).contains(&figure("wrong_claims")) && (0.3..1.0).contains(&figure("coverage")),
            "{cell}"
        );
    }
    for report in ["report.md", "report.csv", "report.html"] {
        let text = workspace.read(&format!("one/{report}"));
        assert!(text.contains("field, tour") && text.contains("2010, chapter 5"), "{report}: {text}");
    }
    assert!(workspace.read("one/report.html").contains("data:image/svg+xml"));

    // Another folder, another number of threads.
    workspace.must(&[&RUN[..], &["--threads", "1", "--out", "two"]].concat());
    assert_eq!(accuracy(&first), accuracy(&cells(&workspace, "two")));

    // What is missing is run again, alone; what is there is not, unless another program made it.
    let some = first.iter().find(|(_, cell)| is_accuracy(cell)).unwrap().0;
    fs::remove_file(workspace.path(&format!("one/cells/{some}"))).unwrap();
    let again = [&RUN[..], &["--out", "one", "--baseline", "two"]].concat();
    let said = workspace.must(&again).stdout;
    let is_cost = |line: &&str| line.contains("[ms]") || line.contains("[MB]");
    let changes: Vec<&str> =
        said.lines().filter(|line| line.contains(" -> ")).filter(|line| !is_cost(line)).collect();
    assert!(
        said.contains("Since two") && changes.is_empty(),
        "times depend on the machine, nothing else: {said}"
    );
    change(&workspace, "one", |cell| cell["figures"]["claimed_position_m"] = 0.25.into());
    let said = workspace.must(&again).stdout;
    assert!(
        said.contains("worse: field, tour; evolutionary; position error while claimed, mean [m]"),
        "{said}"
    );
    assert!(workspace.read("one/report.md").contains("worse: field, tour"));
    let said = workspace.must(&[&RUN[..], &["--out", "two", "--baseline", "one"]].concat()).stdout;
    assert!(said.contains("better: field, tour; evolutionary"), "{said}");
    change(&workspace, "one", |cell| cell["key"]["program"] = "another".into());
    workspace.must(&again);
    assert_eq!(accuracy(&first), accuracy(&cells(&workspace, "one")));
}

#[test]
fn the_simulator_alone_needs_no_files() {
    let workspace = Workspace::new();
    let run =
        ["benchmark", "--quick", "--frames", "30", "--only", "white goals", "--only", "room", "--out", "out"];
    let said = workspace.must(&run).stdout;
    assert!(
        said.contains("white goals, half given (simulated)") && said.contains("room (simulated)"),
        "{said}"
    );
    assert!(said.contains("not to be quoted"), "{said}");
    let told = cells(&workspace, "out")
        .into_values()
        .filter(|cell| cell["key"]["words"].to_string().contains("half:"));
    assert_eq!(told.count(), 2, "accuracy and times of the field whose places have mirror images");
}

#[test]
fn files_without_use_are_named_in_few_lines() {
    let workspace = Workspace::new();
    // Folders whose cameras are still missing.
    for name in ["S7", "S8"] {
        fs::create_dir_all(workspace.path(&format!("data/{name}/rgb"))).unwrap();
        workspace.write(&format!("data/{name}/rgb/0001.png"), "");
    }
    for name in ["a", "b", "c", "d"] {
        workspace.write(&format!("data/{name}.mcap"), "no bag");
    }
    let error = workspace.refused(&["benchmark", "--data", "data", "--only", "nothing"]);
    assert_eq!([error.matches("S7").count(), error.matches("S8").count()], [1, 1], "{error}");
    assert!(error.contains("2 files or folders: ") && error.contains("4 files or folders: "), "{error}");
    assert!(error.contains("data/c.mcap, ...") && !error.contains("data/d.mcap"), "{error}");
}

#[test]
fn what_cannot_be_is_refused_with_a_sentence() {
    let workspace = recordings();
    let error = workspace.refused(&["benchmark", "--data", "nowhere"]);
    assert!(error.contains("nowhere") && error.contains("expected a folder"), "{error}");
    let error = workspace.refused(&["benchmark", "--data", "data/broken.mcap", "--only", "broken"]);
    assert!(error.contains("broken.mcap"), "{error}");
    let error = workspace.refused(&["benchmark", "--only", "room", "--baseline", "data"]);
    assert!(error.contains("expected the results of a benchmark"), "{error}");
    assert!(!workspace.path("out").exists(), "nothing is begun");
}
