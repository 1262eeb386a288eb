//! Numbers that make no sense, for every option of every command that takes one. The options are read from the help, so a
//! new one is tried by itself; a new command with such options needs a line in `cheap_runs`.

use std::{
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use visloc_core::RgbImage;
use visloc_io::image_codec::save_png;

use crate::support::Workspace;

/// What is typed in place of a number.
const NUMBERS: [&str; 7] = ["nan", "inf", "-1", "0", "1e300", "4294967295", "18446744073709551615"];
/// Names of values that are no numbers.
const TEXTS: [&str; 24] = [
    "FILE",
    "DIR",
    "BAG",
    "NAME",
    "NAME|FILE",
    "TOPIC",
    "FRAME",
    "PROGRAM",
    "TOKEN",
    "ADDRESS:PORT",
    "ADDRESS",
    "HOST:PORT",
    "SOURCE",
    "KEY=VALUE",
    "IMAGES",
    "FEATURES",
    "SCHEDULE",
    "PATTERN",
    "MODEL",
    "KIND",
    "HOW",
    "FORMAT",
    "WHAT",
    "STUDY",
];
/// How long a command may take to end, one way or another.
const PATIENCE: Duration = Duration::from_secs(10);

/// Runs of a command that are over in a moment when nothing is wrong, or fail after their options have been looked at.
fn cheap_runs(command: &str) -> &'static [&'static [&'static str]] {
    match command {
        // Pictures take their time; what is wrong with an option shows before.
        "demo" => &[&["--scenario", "no-such.toml"], &["slam", "--scenario", "no-such"]],
        "simulate" => &[&["small.toml", "--out", "simulated.mcap"]],
        "localize" => &[
            &["sim:small.toml"],
            &["no-such.mcap", "--plots", "plots"],
            &["photos", "--map", "robocup-spl-2010", "--camera-height", "0.5"],
        ],
        "locate" => &[&["photos/0.png", "--map", "robocup-spl-2010", "--camera", "no-such.toml"]],
        "slam" => &[&["photos"]],
        "extract" => &[&["photos", "--camera-height", "0.5", "--out", "extracted"]],
        "record" => &[&["photos", "--camera-height", "0.5", "--out", "recorded.mcap"]],
        "studio" => &[&["no-such-source.mcap"]],
        "evaluate" => &[&["poses.tum", "poses.tum"]],
        "benchmark" => &[&["--only", "no-such-recording"]],
        // A part without runs.
        "experiment kidnap" | "experiment team" => &[&["--shard", "900000000/1000000000"]],
        "experiment symmetry" | "experiment markov" => &[&["--shard", "2/1"]],
        "experiment robocup" | "experiment office" => &[&["--algorithm", "no-such"]],
        "experiment slam-configs"
        | "experiment slam-lost-points"
        | "experiment slam-dynamic"
        | "experiment slam-kidnap"
        | "experiment slam-compare" => &[&["no-such-folder"]],
        "experiment merge" => &[&["no-such-folder"]],
        "likelihood" => &[&["no-such.mcap"], &["--view=0,0,0", "--map", "no-such.toml"]],
        "study" => &[&["no-such-study"]],
        "calibrate" => &[
            &["photos", "--size", "9x6", "--square", "0.025"],
            &["photos", "--pattern", "aprilgrid", "--size", "6x6", "--tag", "0.088"],
        ],
        "check-camera" => &[&["camera.toml", "photos"]],
        "calibrate-robot" => &[&["sim:small.toml"]],
        "camera board" => &[
            &["--size", "9x6", "--square", "0.025", "--out", "board.svg"],
            &["--pattern", "aprilgrid", "--size", "6x6", "--tag", "0.088", "--out", "board.svg"],
        ],
        "camera by-hand" => &[&["photos/0.png", "--map", "robocup-spl-2010", "--out", "page.html"]],
        "camera render" => {
            &[&["camera.toml", "--size", "9x6", "--square", "0.025", "--count", "1", "--out", "rendered"]]
        }
        "map merge" => &[&["no-such.vmap", "no-such.vmap", "--out", "both.vmap"]],
        "map trim" => &[&["no-such.vmap", "--keyframes", "5", "--out", "small.vmap"]],
        "map align" => &[
            &["no-such.vmap", "--camera-height", "1", "--out", "aligned.vmap"],
            &["no-such.vmap", "--distance", "1", "--between", "0", "1", "--out", "aligned.vmap"],
        ],
        other => panic!("`visloc {other}` takes numbers: give it a run that is over in a moment"),
    }
}

/// A scenario, images, a calibration and poses, all small.
fn workspace() -> Workspace {
    let workspace = Workspace::new();
    workspace.write(
        "small.toml",
        "duration_secs = 0.1\n[camera]\nsize_px = [64, 48]\nfocal_px = [75.0, 75.0]\ncenter_px = [31.5, 23.5]\n",
    );
    std::fs::create_dir(workspace.path("photos")).unwrap();
    for i in 0..3 {
        save_png(&RgbImage::new(64, 48), &workspace.path(&format!("photos/{i}.png"))).unwrap();
    }
    let camera =
        "model = \"pinhole\"\nsize_px = [64, 48]\nfocal_px = [60.0, 60.0]\ncenter_px = [31.5, 23.5]\n";
    workspace.write("camera.toml", camera);
    workspace.write("photos/camera.yaml", "width: 64\nheight: 48\nfx: 60\nfy: 60\ncx: 31.5\ncy: 23.5\n");
    workspace.write("poses.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n3 2 1 1 0 0 0 1\n");
    workspace
}

/// All commands, with their words; those that only hold others are left out.
fn commands(workspace: &Workspace, words: &[String]) -> Vec<Vec<String>> {
    let help = help_of(workspace, words);
    let inner: Vec<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .collect();
    if inner.is_empty() {
        return vec![words.to_vec()];
    }
    let names = inner.iter().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    names.flat_map(|name| commands(workspace, &[words, &[name.to_owned()]].concat())).collect()
}

fn help_of(workspace: &Workspace, words: &[String]) -> String {
    let words: Vec<&str> = words.iter().map(String::as_str).chain(["--help"]).collect();
    workspace.must(&words).stdout
}

/// Options of a command whose values are numbers.
fn numeric_options(help: &str) -> Vec<String> {
    let option = |line: &str| {
        let (name, value) = line.trim().split_once(" <")?;
        let name = name.rsplit(' ').next().filter(|name| name.starts_with("--"))?;
        let value = value.split_once('>')?.0;
        (!TEXTS.contains(&value)).then(|| name.to_owned())
    };
    help.lines().filter_map(option).collect()
}

/// Runs a command; what it did wrong, if anything.
// A program that hangs has to be ended.
#[allow(clippy::disallowed_methods)]
fn run(workspace: &Workspace, args: &[String]) -> Option<String> {
    let error_path = workspace.path(&format!("stderr-{:?}", thread::current().id()));
    let mut child = Command::new(env!("CARGO_BIN_EXE_visloc"))
        .args(args)
        .current_dir(workspace.path("."))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&error_path).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status,
            None if start.elapsed() > PATIENCE => {
                child.kill().unwrap();
                child.wait().unwrap();
                return Some(format!("{args:?}: goes on after {PATIENCE:?}"));
            }
            None => thread::sleep(Duration::from_millis(3)),
        }
    };
    let said = std::fs::read_to_string(&error_path).unwrap();
    let longest_number = said.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or(0);
    match status.code() {
        Some(0..=2) if !said.contains("panicked") && longest_number < 30 => None,
        code => Some(format!("{args:?}: ended with {code:?}: {said}")),
    }
}

#[test]
fn senseless_numbers_end_every_command_soon_and_with_a_sentence() {
    let workspace = workspace();
    let mut all: Vec<Vec<String>> = Vec::new();
    for words in commands(&workspace, &[]) {
        let help = help_of(&workspace, &words);
        let options = numeric_options(&help);
        if options.is_empty() {
            continue;
        }
        for base in cheap_runs(&words.join(" ")) {
            for option in &options {
                // The number stands in place of the one that keeps the run short.
                let at = base.iter().position(|word| word == option);
                let rest =
                    base.iter().enumerate().filter(|(i, _)| at.is_none_or(|at| *i != at && *i != at + 1));
                let rest: Vec<String> = rest.map(|(_, word)| (*word).to_owned()).collect();
                for number in NUMBERS {
                    all.push([&words[..], &rest, &[format!("{option}={number}")]].concat());
                }
            }
        }
    }
    assert!(all.len() > 500, "the help has another form: {} runs", all.len());
    let halves = all.split_at(all.len() / 2);
    let faults = thread::scope(|scope| {
        let runs =
            |part: &[Vec<String>]| part.iter().filter_map(|args| run(&workspace, args)).collect::<Vec<_>>();
        let first = scope.spawn(move || runs(halves.0));
        let second = runs(halves.1);
        [first.join().unwrap(), second].concat()
    });
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn calibrations_that_no_lens_has_are_refused() {
    let workspace = workspace();
    for (key, value, expected) in [
        ("fx", "1e-9", "degrees, and no lens does that"),
        ("fx", "1e9", "degrees, and no lens does that"),
        ("fx", "0", "positive focal lengths"),
        ("fx", "nan", "number"),
        ("cx", "1e300", "principal point"),
        ("k1", "1e300", "distortion"),
        ("k1", "-1e6", "distortion"),
        ("width", "1e300", "whole pixels"),
    ] {
        let mut lines = vec![
            ("width", "64"),
            ("height", "48"),
            ("fx", "60"),
            ("fy", "60"),
            ("cx", "31.5"),
            ("cy", "23.5"),
        ];
        lines.retain(|(name, _)| *name != key);
        lines.push((key, value));
        let text: String = lines.iter().map(|(name, value)| format!("{name}: {value}\n")).collect();
        workspace.write("bad.yaml", &text);
        let error = workspace.refused(&["slam", "photos", "--camera", "bad.yaml"]);
        assert!(error.contains(expected) && error.len() < 400, "{key} = {value}: {error}");
    }
}
