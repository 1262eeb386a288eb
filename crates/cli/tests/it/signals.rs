//! Ctrl-C and its kin end a command with all results so far.

#![cfg(unix)]

use std::{
    fs,
    process::{Child, Command, ExitStatus},
    time::{Duration, Instant},
};

use visloc_core::Source;
use visloc_io::{
    bag::{BagReader, BagTopics},
    image_codec::read_image,
};
use visloc_studio::recording::RecordingIndex;

use crate::support::{Workspace, data_lines, write_program};

/// Longest time until a command has begun, and until it has ended.
const MOST: Duration = Duration::from_secs(60);

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[allow(clippy::disallowed_methods)]
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun_at = Instant::now();
    while !is_so() {
        assert!(begun_at.elapsed() < MOST, "{what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn end_of(child: &mut Child, what: &str) -> ExitStatus {
    let mut status = None;
    wait_until(what, || {
        status = child.try_wait().unwrap();
        status.is_some()
    });
    status.unwrap()
}

/// A command that would run for a minute and longer.
struct Case {
    args: &'static [&'static str],
    /// It has begun when this file has more bytes.
    begun: (&'static str, u64),
    code: i32,
    check: fn(&Workspace),
}

fn num_frames(workspace: &Workspace, name: &str) -> usize {
    let mut reader = BagReader::open(workspace.path(name), BagTopics::default()).unwrap();
    std::iter::from_fn(|| reader.next_item()).map(Result::unwrap).count()
}

fn has(workspace: &Workspace, names: &[&str]) {
    for name in names {
        assert!(fs::metadata(workspace.path(name)).is_ok_and(|found| found.len() > 0), "{name}");
    }
}

const CASES: [Case; 10] = [
    Case {
        args: &[
            "localize",
            "sim:tour",
            "--estimates",
            "r.csv",
            "--trajectory",
            "r.tum",
            "--json",
            "r.json",
            "--bag-out",
            "b.mcap",
            "--record",
            "s.mcap",
            "--plots",
            "plots",
        ],
        begun: ("b.mcap", 100_000),
        code: 130,
        check: |workspace| {
            let num = usize::try_from(workspace.json("r.json")["frames"].as_u64().unwrap()).unwrap();
            assert!(num > 0);
            assert_eq!(workspace.read("r.csv").lines().count(), num + 1);
            assert_eq!(data_lines(&workspace.read("r.tum")).len(), num);
            assert_eq!(num_frames(workspace, "b.mcap"), num);
            assert_eq!(RecordingIndex::open(&workspace.path("s.mcap")).unwrap().num_frames(), num);
            has(workspace, &["plots/errors.png", "plots/trajectories.svg"]);
        },
    },
    Case {
        args: &["simulate", "tour", "--out", "b.mcap", "--json", "s.json"],
        begun: ("b.mcap", 100_000),
        code: 130,
        check: |workspace| {
            let num = usize::try_from(workspace.json("s.json")["frames"].as_u64().unwrap()).unwrap();
            assert_eq!(num_frames(workspace, "b.mcap"), num);
            assert_eq!(data_lines(&workspace.read("b.truth.tum")).len(), num);
        },
    },
    Case {
        args: &["record", "sim:tour", "--out", "bag"],
        begun: ("bag/bag_0.mcap", 100_000),
        code: 130,
        check: |workspace| {
            has(workspace, &["bag/metadata.yaml"]);
            assert!(num_frames(workspace, "bag") > 0);
        },
    },
    Case {
        args: &[
            "slam",
            "sim:room",
            "--trajectory",
            "t.tum",
            "--points",
            "p.ply",
            "--keyframes",
            "k.tum",
            "--log",
            "l.csv",
            "--json",
            "s.json",
            "--record",
            "s.mcap",
            "--plots",
            "plots",
        ],
        begun: ("s.mcap", 500_000),
        code: 130,
        check: |workspace| {
            has(workspace, &["t.tum", "p.ply", "k.tum", "s.json", "plots/courses.png"]);
            let num = workspace.read("l.csv").lines().count() - 1;
            assert_eq!(RecordingIndex::open(&workspace.path("s.mcap")).unwrap().num_frames(), num);
        },
    },
    Case {
        args: &["demo", "--out", "d", "--json", "d.json"],
        begun: ("d/evolutionary.csv.part", 1000),
        code: 130,
        check: |workspace| {
            has(
                workspace,
                &[
                    "d/evolutionary.csv",
                    "d/mcae.tum",
                    "d/truth.tum",
                    "d/summary.json",
                    "d/errors.png",
                    "d.json",
                ],
            );
        },
    },
    Case {
        args: &["demo", "slam", "--out", "d"],
        begun: ("d/frame-00000.png", 0),
        code: 130,
        check: |workspace| {
            has(workspace, &["d/estimate.tum", "d/map.ply", "d/summary.json", "d/courses.png"])
        },
    },
    Case {
        args: &["experiment", "kidnap", "--runs", "100000", "--out", "e", "--json", "e.json"],
        begun: ("e/records.jsonl", 0),
        code: 130,
        check: |workspace| has(workspace, &["e/report.txt", "e/report.json", "e/kidnap.csv", "e.json"]),
    },
    // A run takes half a minute and longer, and is not waited for.
    Case {
        args: &["experiment", "slam-kidnap", "--out", "e", "--json", "e.json"],
        begun: ("e/experiment.json", 0),
        code: 130,
        check: |workspace| {
            has(workspace, &["e/report.txt", "e/report.json", "e.json"]);
            assert_eq!(workspace.read("e/records.jsonl"), "");
        },
    },
    Case {
        args: &["extract", "sim:tour", "--out", "d"],
        begun: ("d/camera.yaml", 0),
        code: 130,
        check: |workspace| has(workspace, &["d/rgb.txt", "d/camera.yaml"]),
    },
    Case {
        args: &["studio", "--no-open", "--port", "0", "--recordings", "out"],
        begun: ("stdout", 10),
        code: 0,
        check: |_| {},
    },
];

#[test]
fn every_long_command_ends_with_all_results_so_far() {
    for (case, signal) in CASES.iter().zip(["-INT", "-TERM"].into_iter().cycle()) {
        let workspace = Workspace::new();
        let what = format!("{signal} {:?}", case.args);
        let output = |name: &str| fs::File::create(workspace.path(name)).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
        command.args(case.args).current_dir(workspace.path("."));
        let mut child = command.stdout(output("stdout")).stderr(output("stderr")).spawn().unwrap();
        let (file, num_bytes) = case.begun;
        wait_until(&what, || {
            assert_eq!(child.try_wait().unwrap(), None, "{what}: {}", workspace.read("stderr"));
            fs::metadata(workspace.path(file)).is_ok_and(|found| found.len() > num_bytes)
        });
        send(signal, &child);
        let status = end_of(&mut child, &what);
        assert_eq!(status.code(), Some(case.code), "{what}: {}", workspace.read("stderr"));
        let said = workspace.read("stderr");
        assert_eq!(said.lines().count(), usize::from(case.code != 0), "{what}: {said}");
        assert_eq!(said.contains("interrupted"), case.code != 0, "{what}: {said}");
        (case.check)(&workspace);
    }
}

/// By the system's account of the process; where there is none, after a while.
fn are_signals_caught(child: &Child) -> bool {
    let Ok(status) = fs::read_to_string(format!("/proc/{}/status", child.id())) else {
        std::thread::sleep(Duration::from_millis(300));
        return true;
    };
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or_default();
    // SIGINT is 2, SIGTERM 15.
    u64::from_str_radix(caught.trim(), 16).is_ok_and(|caught| caught >> 1 & caught >> 14 & 1 == 1)
}

/// Commands that compute something of which there is no half, or have not begun.
#[test]
fn what_has_no_half_ends_at_once_and_says_so() {
    let commands: [&[&str]; 2] =
        [&["likelihood", "--view", "1,0.5,30", "--step", "0.01"], &["benchmark", "--out", "b"]];
    for (args, signal) in commands.iter().zip(["-TERM", "-INT"]) {
        let workspace = Workspace::new();
        let stderr = fs::File::create(workspace.path("stderr")).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
        let mut child = command.args(*args).current_dir(workspace.path(".")).stderr(stderr).spawn().unwrap();
        wait_until("signals are caught", || are_signals_caught(&child));
        send(signal, &child);
        assert_eq!(end_of(&mut child, args[0]).code(), Some(130), "{args:?}");
        let said = workspace.read("stderr");
        assert!(said.contains("interrupted"), "{args:?}: {said}");
    }
}

#[test]
fn a_second_signal_ends_at_once() {
    let workspace = Workspace::new();
    let mut child = workspace.start(&["localize", "sim:tour", "--plots", "plots", "--bag-out", "b.mcap"]);
    wait_until("begun", || fs::metadata(workspace.path("b.mcap")).is_ok_and(|found| found.len() > 100_000));
    send("-INT", &child);
    send("-TERM", &child);
    assert_eq!(end_of(&mut child, "two signals").code(), Some(130));
    assert!(!workspace.path("plots").join("analysis.png").exists(), "no pictures any more");
}

/// A map of many images with known poses is found after the last image, which takes longer than all images together.
#[test]
fn an_end_that_takes_long_says_so_and_a_second_signal_ends_it() {
    let workspace = Workspace::new();
    workspace.must(&["slam", "sim:room", "--frames", "250", "--trajectory", "way.tum"]);
    workspace.write("m.vmap", "an earlier one");
    let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
    command.args(["slam", "sim:room", "--frames", "250", "--poses", "way.tum", "--save", "m.vmap"]);
    let stdout = fs::File::create(workspace.path("stdout")).unwrap();
    let mut child = command.current_dir(workspace.path(".")).stdout(stdout).spawn().unwrap();
    wait_until("signals are caught", || are_signals_caught(&child));
    std::thread::sleep(Duration::from_millis(1500));
    send("-INT", &child);
    wait_until("a note", || workspace.read("stdout").contains("a second signal ends at once"));
    send("-INT", &child);
    assert_eq!(end_of(&mut child, "two signals").code(), Some(130));
    assert_eq!(workspace.read("m.vmap"), "an earlier one");
}

/// Programs in place of ffmpeg that stall: at once, and after three images.
const STALLING: [(&str, &str); 2] = [
    ("#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nexec sleep 100\n", "before anything was computed"),
    (
        "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor i in 1 2 3; do printf 'P5 64 48 255\\n'; head -c 3072 /dev/zero; done\n\
         exec sleep 100\n",
        "what was computed until then is saved",
    ),
];

#[test]
fn a_source_that_stalls_is_ended_by_the_first_signal() {
    for (script, said) in STALLING {
        let workspace = Workspace::new();
        write_program(&workspace.path("stalling"), script);
        workspace.write("clip.mp4", "");
        workspace.write(
            "camera.toml",
            "model = \"pinhole\"\nsize_px = [64, 48]\nfocal_px = [50, 50]\ncenter_px = [32, 24]\n",
        );
        let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
        command.args([
            "slam",
            "clip.mp4",
            "--camera",
            "camera.toml",
            "--ffmpeg",
            "./stalling",
            "--log",
            "l.csv",
        ]);
        let stderr = fs::File::create(workspace.path("stderr")).unwrap();
        let mut child = command.current_dir(workspace.path(".")).stderr(stderr).spawn().unwrap();
        wait_until("waiting", || workspace.read("stderr").contains("clip.mp4: no image for 3.0 s, waiting"));
        send("-INT", &child);
        assert_eq!(end_of(&mut child, "stalling").code(), Some(130));
        let stderr = workspace.read("stderr");
        assert!(stderr.contains(said), "{stderr}");
    }
}

/// There is no half of a camera that is found from its own motion.
#[test]
fn finding_a_camera_from_its_motion_is_ended_by_the_first_signal() {
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip/rgb");
    let commands: [&[&str]; 2] =
        [&["calibrate", "images", "--out", "c.toml"], &["slam", "images", "--save", "c.toml"]];
    for (args, signal) in commands.iter().zip(["-INT", "-TERM"]) {
        let workspace = Workspace::new();
        fs::create_dir(workspace.path("images")).unwrap();
        for image in fs::read_dir(clip).unwrap().map(|image| image.unwrap().path()) {
            fs::copy(&image, workspace.path("images").join(image.file_name().unwrap())).unwrap();
        }
        let output = |name: &str| fs::File::create(workspace.path(name)).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
        command
            .args(*args)
            .current_dir(workspace.path("."))
            .stdout(output("stdout"))
            .stderr(output("stderr"));
        let mut child = command.spawn().unwrap();
        wait_until("begun", || workspace.read("stdout").contains("from its own motion"));
        // All images have been read by then.
        std::thread::sleep(Duration::from_millis(300));
        send(signal, &child);
        assert_eq!(end_of(&mut child, args[0]).code(), Some(130), "{args:?}");
        let said = workspace.read("stderr");
        assert!(said.contains("interrupted"), "{args:?}: {said}");
        assert!(!workspace.path("c.toml").exists(), "{args:?}");
    }
}

/// A program in place of ffmpeg, which runs in the folder of the pictures, hands on one every half second; a camera needs three.
#[test]
fn a_live_calibration_that_is_ended_is_that_of_the_pictures_until_then() {
    let workspace = Workspace::new();
    workspace.write(
        "truth.toml",
        "model = \"pinhole\"\nsize_px = [320, 240]\nfocal_px = [300, 300]\ncenter_px = [160, 120]\n",
    );
    let board = ["--size", "9x6", "--square", "0.03"];
    let render = ["camera", "render", "truth.toml", "--out", "photos", "--count", "12"];
    assert_eq!(workspace.visloc(&[&render[..], &board].concat()).code, 0);
    for photo in fs::read_dir(workspace.path("photos")).unwrap() {
        let photo = photo.unwrap().path();
        if let Ok(image) = read_image(&photo) {
            fs::write(photo.with_extension("ppm"), [b"P6 320 240 255\n", image.data()].concat()).unwrap();
        }
    }
    write_program(
        &workspace.path("camera"),
        "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor photo in *.ppm; do cat \"$photo\"; sleep 0.5; done\n\
         touch all\nexec sleep 100\n",
    );
    let args = ["calibrate", "loop:photos", "--ffmpeg", "./camera", "--out", "camera.toml"];
    let mut child = workspace.start(&[&args[..], &board].concat());
    wait_until("pictures", || workspace.path("photos/all").exists());
    send("-INT", &child);
    assert_eq!(end_of(&mut child, "calibrate").code(), Some(0));
    assert!(workspace.read("camera.toml").contains("focal_px"));
}

/// A program that listens to topics begins anew, as the same process, with a limit for blocks of memory; one that the user has set stays.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn who_listens_for_hours_returns_its_memory() {
    const LIMIT: &str = "MALLOC_MMAP_THRESHOLD_";
    for (own, expected) in [(None, "16384"), (Some("65536"), "65536")] {
        let workspace = Workspace::new();
        let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
        command.args(["localize", "ros2:/nobody", "--map", "robocup-spl-2010"]).env_remove(LIMIT);
        command.envs(own.map(|own| (LIMIT, own))).current_dir(workspace.path("."));
        let mut child = command.stderr(std::process::Stdio::null()).spawn().unwrap();
        let limit = format!("{LIMIT}={expected}");
        wait_until("the limit", || {
            let environment = fs::read(format!("/proc/{}/environ", child.id())).unwrap();
            environment.split(|byte| *byte == 0).any(|variable| variable == limit.as_bytes())
        });
        wait_until("signals are caught", || are_signals_caught(&child));
        send("-INT", &child);
        assert_eq!(end_of(&mut child, "listening").code(), Some(130));
    }
}
