//! Outputs never harm inputs, are tried before the run, and are all saved even if one cannot be.

use std::fs;

use crate::support::{MAP, Workspace, data_lines, excerpt_text};

/// The options of commands that write, with what they need besides `b.mcap`, a recording.
const COMMANDS: [&[&str]; 13] = [
    &["record", "b.mcap", "--out"],
    &["localize", "b.mcap", "--map", MAP, "--bag-out"],
    &["localize", "b.mcap", "--map", MAP, "--record"],
    &["localize", "b.mcap", "--map", MAP, "--estimates"],
    &["localize", "b.mcap", "--map", MAP, "--json"],
    &["localize", "b.mcap", "--map", MAP, "--robot-out"],
    &["slam", "b.mcap", "--trajectory"],
    &["slam", "b.mcap", "--points"],
    &["slam", "bag:b.mcap", "--map"],
    &["calibrate-robot", "b.mcap", "--map", MAP, "--out"],
    &["likelihood", "b.mcap", "--map", MAP, "--json"],
    &["studio", "--replay", "b.mcap", "--export"],
    &["check-camera", "camera.toml", "b.mcap", "--json"],
];

#[cfg(unix)]
#[test]
fn a_recording_is_never_written_over_by_what_is_made_of_it() {
    let workspace = Workspace::new();
    workspace.bag("b.mcap", 3, |_, _| {});
    let bytes = fs::read(workspace.path("b.mcap")).unwrap();
    std::os::unix::fs::symlink("b.mcap", workspace.path("link.mcap")).unwrap();
    fs::hard_link(workspace.path("b.mcap"), workspace.path("hard.mcap")).unwrap();
    let absolute = workspace.path("b.mcap").display().to_string();
    for command in COMMANDS {
        for name in ["b.mcap", "./b.mcap", "link.mcap", "hard.mcap", &absolute] {
            let error = workspace.refused(&[command, &[name]].concat());
            assert!(error.contains(name) && error.contains("which is read"), "{command:?} {name}: {error}");
            assert!(fs::read(workspace.path("b.mcap")).unwrap() == bytes, "{command:?} {name}");
        }
    }
}

#[test]
fn recordings_that_are_there_are_replaced_on_demand_only() {
    let workspace = Workspace::new();
    let simulate = ["simulate", "still", "--frames", "2", "--out", "s.mcap"];
    let record = ["record", "sim:still", "--frames", "3", "--out", "bag"];
    workspace.must(&simulate);
    workspace.must(&record);
    let before = fs::read(workspace.path("s.mcap")).unwrap();
    for command in [&simulate[..], &record[..]] {
        let error = workspace.refused(command);
        assert!(error.contains("--overwrite"), "{error}");
        workspace.must(&[command, &["--overwrite"]].concat());
    }
    assert_eq!(fs::read(workspace.path("s.mcap")).unwrap(), before, "the same again");
    workspace.must(&["simulate", "still", "--frames", "2"]);
    assert!(workspace.refused(&["simulate", "still"]).contains("out/still.mcap"), "the usual name as well");
}

#[cfg(unix)]
#[test]
fn a_stream_that_leads_to_a_file_is_written_to_and_not_replaced() {
    let workspace = Workspace::new();
    workspace.write("t.csv", "t,x,y,yaw\n1,0,0,0\n2,1,0,0\n");
    workspace.write("e.csv", "t,x,y,yaw\n1,0,0,0\n2,1,0,0\n");
    for stream in ["/dev/stdout", "/proc/self/fd/1", "-"] {
        workspace.write("both.txt", "the shell's\n");
        let file = fs::File::options().append(true).open(workspace.path("both.txt")).unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_visloc"));
        let command = command.args(["evaluate", "t.csv", "e.csv", "--as", "robot", "--json", stream]);
        let output = command.current_dir(workspace.path("")).stdout(file).output().unwrap();
        let text = workspace.read("both.txt");
        // What programs read is the result alone; what people read is said on standard error.
        assert!(output.status.success() && text.starts_with("the shell's\n{\n"), "{text}");
        assert!(text.contains("\"frames\": 2") && text.ends_with("}\n"), "{text}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.starts_with("2 frames in common"), "{said}");
    }
    assert!(!workspace.path("-").exists());
    let both = ["localize", "sim:tour", "--frames", "2", "--json", "-", "--estimates", "-"];
    assert!(workspace.refused(&both).contains("expected another file"), "two results are not told apart");
    let said = workspace.visloc(&["slam", "sim:room", "--until", "5", "--json", "-"]);
    assert!(
        said.code == 0 && said.stdout.starts_with('{') && !said.stderr.contains("/dev/stdout"),
        "{}",
        said.stderr
    );
}

#[test]
fn outputs_are_tried_before_the_run() {
    let workspace = Workspace::new();
    workspace.write("file", "kept");
    fs::create_dir(workspace.path("folder")).unwrap();
    let long = "a".repeat(300);
    // Without the check these would run for minutes.
    for (options, expected) in [
        (["--json", "folder"], "found a folder"),
        (["--plots", "file"], "expected a folder"),
        (["--trajectory", "file/below.tum"], "cannot write there"),
        (["--bag-out", "file/bag.mcap"], "cannot write there"),
        #[cfg(target_os = "linux")]
        (["--estimates", "/proc/robot.csv"], "cannot write there"),
        (["--json", "new/"], "expected the name of a file"),
        (["--trajectory", "new/"], "expected the name of a file"),
        (["--bag-out", "new.mcap/"], "expected the name of a file"),
        (["--json", &long], "too long"),
        (["--bag-out", "run.mp4"], "recordings are written as MCAP"),
    ] {
        let error = workspace.refused(&[&["localize", "sim:tour"], &options[..]].concat());
        assert!(error.contains(options[1]) && error.contains(expected), "{error}");
    }
    let below = ["localize", "sim:tour", "--trajectory", "new.tum", "--plots", "new.tum/plots"];
    assert!(
        workspace.refused(&below).contains("no folder for other results")
            && !workspace.path("new.tum").exists()
    );
    assert_eq!(workspace.read("file"), "kept");
    assert_eq!(fs::read_dir(workspace.path("folder")).unwrap().count(), 0);
}

/// A full disk, as the system has one for trying.
#[cfg(target_os = "linux")]
#[test]
fn one_output_that_fails_does_not_take_the_others_along() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    std::os::unix::fs::symlink("/dev/full", workspace.path("full.mcap")).unwrap();
    let run = ["localize", &bag, "--map", MAP, "--frames", "5", "--trajectory", "r.tum"];
    for (full, place, kept) in [
        ("--estimates", "/dev/full", "--json"),
        ("--json", "/dev/full", "--estimates"),
        ("--bag-out", "full.mcap", "--json"),
        ("--record", "full.mcap", "--json"),
    ] {
        let error = workspace.refused(&[&run[..], &[full, place, kept, "kept"]].concat());
        assert!(error.contains(place) && error.contains("No space left on device"), "{full}: {error}");
        assert!(!workspace.read("kept").is_empty(), "{full}");
        assert_eq!(data_lines(&workspace.read("r.tum")).len(), 5, "{full}");
        fs::remove_file(workspace.path("kept")).unwrap();
    }
    let run = ["slam", "sim:room", "--until", "12", "--trajectory", "s.tum", "--json", "s.json"];
    let error = workspace.refused(
        &[&run[..], &["--points", "/dev/full", "--log", "/dev/full", "--record", "/dev/full"]].concat(),
    );
    assert_eq!(error.matches("No space left on device").count(), 3, "each is told: {error}");
    assert!(workspace.json("s.json")["frames"].is_u64() && !workspace.read("s.tum").is_empty());
    let simulate = ["simulate", "still", "--frames", "30", "--out", "full.mcap", "--json", "m.json"];
    let outcome = workspace.visloc(&simulate);
    let error = &outcome.stderr;
    assert!(error.contains("full.mcap") && error.matches("cannot write").count() == 1, "{error}");
    assert!(error.contains("No space left on device") && !outcome.stdout.contains("next:"), "{error}");
    assert!(workspace.json("m.json")["frames"].is_u64(), "the numbers of what was written");
}

#[test]
fn nothing_else_is_left_of_a_run() {
    let workspace = Workspace::new();
    workspace.must(&[
        "localize",
        "sim:still",
        "--frames",
        "3",
        "--trajectory",
        "out/r.tum",
        "--estimates",
        "out/r.csv",
    ]);
    let entries = fs::read_dir(workspace.path("out")).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["r.csv", "r.tum"]);
}

/// Whole files are read with a bound and written so that no half of them has their name; devices that never end are refused.
#[test]
fn files_are_read_and_written_in_one_place() {
    /// What reads and writes files in other ways, and why it may.
    const OTHERS: [&str; 9] = [
        "core/src/files/mod.rs",
        "core/src/files/write.rs",
        // Recordings that grow, and are read record by record.
        "io/src/bag/channels.rs",
        "studio/src/recording/index.rs",
        // Records of experiments that are appended.
        "experiments/src/framework/store.rs",
        // Looks at the first bytes of a file.
        "cli/src/claims/check.rs",
        // Takes a name that is free.
        "studio/src/new_file.rs",
        // Frames of the measurement of detections, for people.
        "scenarios/src",
        // Has no access to the place.
        "world/src",
    ];
    const CALLS: [&str; 7] = [
        "fs::write(",
        "fs::read(",
        "fs::read_to_string(",
        "File::create",
        "File::open(",
        "File::options(",
        "OpenOptions",
    ];
    let calls_one = |line: &str| {
        let is_whole_word = |i: usize| !line[..i].ends_with(|c: char| c.is_alphanumeric());
        let is_call = |call: &str| line.match_indices(call).any(|(i, _)| is_whole_word(i));
        !line.trim_start().starts_with("//") && CALLS.iter().any(|call| is_call(call))
    };
    let crates = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut folders: Vec<_> =
        fs::read_dir(crates).unwrap().map(|entry| entry.unwrap().path().join("src")).collect();
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path()) {
            let name = path.strip_prefix(crates).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs")
                && !name.contains("tests")
                && !OTHERS.iter().any(|other| name.starts_with(other))
            {
                let text = fs::read_to_string(&path).unwrap();
                let program = text.split("#[cfg(test)]").next().unwrap_or_default();
                let calls = program.lines().filter(|line| calls_one(line));
                found.extend(calls.map(|line| format!("{name}: {}", line.trim())));
            }
        }
    }
    assert!(found.is_empty(), "use visloc_core::files:\n{}", found.join("\n"));
}

/// Whatever replaces a file of the user keeps it: trajectories, calibrations, numbers, the truth beside a recording.
#[test]
fn what_is_replaced_is_kept() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip");
    let camera = format!("{clip}/camera.yaml");
    let commands: [(&[&str], &[&str]); 4] = [
        (
            &[
                "localize",
                &bag,
                "--map",
                MAP,
                "--frames",
                "2",
                "--trajectory",
                "a",
                "--estimates",
                "b",
                "--json",
                "c",
            ],
            &["a", "b", "c"],
        ),
        (
            &[
                "slam",
                clip,
                "--until",
                "2",
                "--trajectory",
                "a",
                "--points",
                "b",
                "--keyframes",
                "c",
                "--log",
                "d",
            ],
            &["a", "b", "c", "d"],
        ),
        (&["simulate", "still", "--frames", "2", "--out", "s.mcap"], &["s.truth.tum"]),
        (&["camera", "convert", &camera, "c.toml"], &["c.toml"]),
    ];
    for (command, names) in commands {
        names.iter().for_each(|name| workspace.write(name, "precious"));
        let said = workspace.must(command).stdout;
        for name in names {
            assert_eq!(workspace.read(&format!("{name}~")), "precious", "{command:?} {name}");
            assert!(said.contains(&format!("is kept as {name}~")), "{command:?} {name}: {said}");
            assert_ne!(workspace.read(name), "precious");
        }
    }
    workspace.write("a.part", "somebody's own");
    workspace.must(&["localize", &bag, "--map", MAP, "--frames", "2", "--trajectory", "a"]);
    assert_eq!(workspace.read("a.part~"), "somebody's own");
    workspace.write("b.part", "of a run that was killed");
    let said = workspace.must(&["localize", "sim:still", "--frames", "2", "--trajectory", "b"]).stdout;
    assert!(said.contains("is kept as b.part~"), "{said}");
    fs::copy(&bag, workspace.path("c.part")).unwrap();
    let error = workspace.refused(&["localize", "bag:c.part", "--map", MAP, "--trajectory", "c"]);
    assert!(error.contains("c.part, which is read"), "{error}");
    fs::create_dir(workspace.path("b.part")).unwrap();
    let error = workspace.refused(&["localize", &bag, "--map", MAP, "--frames", "2", "--trajectory", "b"]);
    assert!(error.contains("b.part, found a folder of that name"), "{error}");
    let error =
        workspace.refused(&["localize", &bag, "--map", MAP, "--plots", "p", "--json", "p/errors.png"]);
    assert!(error.contains("--plots p writes pictures there"), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_no_success() {
    let workspace = Workspace::new();
    for words in
        [&["maps"][..], &["--help"], &["map", "check", MAP], &["evaluate", "t.csv", "t.csv", "--as", "robot"]]
    {
        workspace.write("t.csv", "t,x,y,yaw\n1,0,0,0\n2,1,0,0\n");
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_visloc"));
        let output = command.args(words).current_dir(workspace.path("")).stdout(full).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{words:?}: {error}");
        assert!(error.contains("standard output: No space left on device"), "{words:?}: {error}");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_that_nobody_reads_is_refused() {
    let workspace = Workspace::new();
    assert!(std::process::Command::new("mkfifo").arg(workspace.path("pipe")).status().unwrap().success());
    let bag = excerpt_text("R1");
    for option in ["--json", "--estimates"] {
        let error = workspace.refused(&["localize", &bag, "--map", MAP, "--frames", "2", option, "pipe"]);
        assert!(error.contains("pipe") && error.contains("nobody reads this pipe"), "{error}");
    }
    let error = workspace.refused(&["localize", "pipe", "--map", MAP]);
    assert!(error.contains("found a device, pipe or socket"), "{error}");
}

#[test]
fn a_recording_that_another_program_writes_is_refused_before_the_run() {
    let workspace = Workspace::new();
    workspace.write("busy.mcap", "in the making");
    let held = fs::File::options().append(true).open(workspace.path("busy.mcap")).unwrap();
    held.lock().unwrap();
    // Without the check these would run for minutes.
    for output in ["--bag-out", "--record", "--json"] {
        let error = workspace.refused(&["localize", "sim:tour", output, "busy.mcap", "--overwrite"]);
        assert!(error.contains("busy.mcap") && error.contains("another program is writing it"), "{error}");
    }
    assert_eq!(workspace.read("busy.mcap"), "in the making");
}

#[test]
fn what_prints_a_text_writes_it_to_a_file_as_well() {
    let workspace = Workspace::new();
    let size = "length: 6\nwidth: 4\nborder: 0.7\nline: 0.05\ncircle_diameter: 1.2\npenalty_depth: 0.6\npenalty_width: 2.2\n";
    let goals = "cross_from_goal_line: 1.8\ngoal_inner_width: 1.4\ngoal_inner_height: 0.8\npost_diameter: 0.1\nball_diameter: 0.065\n\
                 centre_mark: 0.1\ngoals:\n  - {color: yellow, x: 3}\n  - {color: blue, x: -3}\n";
    workspace.write("field.yaml", &format!("{size}{goals}"));
    let plan = excerpt_text("O1").replace("O1-excerpt.mcap", "O1-map.yaml");
    for command in [
        &["map", "import", &plan][..],
        &["map", "import", "field.yaml"],
        &["map", "show", MAP],
        &["config", "show", "mce"],
    ] {
        let printed = workspace.must(command).stdout;
        workspace.must(&[command, &["--out", "text.toml"]].concat());
        assert_eq!(workspace.read("text.toml"), printed, "{command:?}");
        assert_eq!(workspace.must(&[command, &["--out", "-"]].concat()).stdout, printed, "{command:?}");
        if command[0] == "map" {
            workspace.must(&["map", "check", "text.toml"]);
        }
        fs::remove_file(workspace.path("text.toml")).unwrap();
    }
    let error = workspace.refused(&["map", "import", "field.yaml", "--out", "field.yaml"]);
    assert!(error.contains("which is read"), "{error}");
}

#[test]
fn points_are_no_map() {
    let workspace = Workspace::new();
    for name in ["office", "room.vmap", "field.toml"] {
        let error = workspace.refused(&["slam", "sim:room", "--map", name]);
        assert!(error.contains("FILE.ply") && error.contains("visloc localize --map"), "{error}");
    }
}
