//! `visloc slam` on bad input, and `visloc evaluate` of what it writes.

use std::{fs, path::Path};

use visloc_core::RgbImage;
use visloc_io::image_codec::{read_image, save_png};

use crate::support::{Workspace, data_lines};

const CAMERA: &str = "width: 320\nheight: 240\nfx: 262.5\nfy: 262.5\ncx: 159.5\ncy: 119.5\n";

fn clip() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip")
}

/// Lines `SECONDS FILE` of the clip, with the whole path of the file.
fn clip_lines() -> Vec<(String, String)> {
    let text = fs::read_to_string(clip().join("rgb.txt")).unwrap();
    data_lines(&text)
        .into_iter()
        .map(|line| {
            let (stamp, file) = line.split_once(' ').unwrap();
            (stamp.to_owned(), clip().join(file).display().to_string())
        })
        .collect()
}

/// A sequence of these lines.
fn sequence(workspace: &Workspace, name: &str, lines: &[(String, String)], camera: &str) {
    fs::create_dir_all(workspace.path(name)).unwrap();
    let list: String = lines.iter().map(|(stamp, file)| format!("{stamp} {file}\n")).collect();
    workspace.write(&format!("{name}/rgb.txt"), &list);
    workspace.write(&format!("{name}/camera.yaml"), camera);
    let truth = fs::read_to_string(clip().join("groundtruth.txt")).unwrap();
    workspace.write(&format!("{name}/groundtruth.txt"), &truth);
}

fn flat_image(workspace: &Workspace, name: &str, size: (u32, u32), level: u8) -> String {
    let mut image = RgbImage::new(size.0, size.1);
    image.data_mut().fill(level);
    save_png(&image, &workspace.path(name)).unwrap();
    workspace.path(name).display().to_string()
}

#[test]
fn bad_images_are_left_out_and_the_rest_is_tracked() {
    let workspace = Workspace::new();
    let mut lines = clip_lines();
    lines[20].1 = "/nowhere/gone.jpg".to_owned();
    lines[25].1 = flat_image(&workspace, "small.png", (160, 120), 90);
    workspace.write("cut.jpg", "no image at all");
    lines[30].1 = workspace.path("cut.jpg").display().to_string();
    lines[40].0 = lines[39].0.clone();
    lines[45].0 = lines[10].0.clone();
    // A line in a wrong place of the list costs nothing.
    let moved = lines.remove(55);
    lines.insert(50, moved);
    sequence(&workspace, "broken", &lines, CAMERA);
    let outcome =
        workspace.must(&["slam", "broken", "--json", "r.json", "--trajectory", "t.tum", "--map", "m.ply"]);
    for expected in
        ["left out", "gone.jpg", "expected 320 x 240 px, found 160 x 120", "expected one image at a time"]
    {
        assert!(outcome.stdout.contains(expected), "{expected}: {}", outcome.stdout);
    }
    let report = workspace.json("r.json");
    assert_eq!(report["skipped"], 5);
    // Lines that name no image are none.
    assert_eq!(report["frames"], clip_lines().len() - 2);
    let lines = std::iter::once(("no time".to_owned(), "x.png".to_owned())).chain(lines).collect::<Vec<_>>();
    sequence(&workspace, "broken", &lines, CAMERA);
    let outcome = workspace.must(&["slam", "broken", "--frames", "20"]);
    assert!(outcome.stdout.contains("broken: 20 frames\n"), "{}", outcome.stdout);
    assert!(report["coverage"].as_f64().unwrap() > 0.7, "{report}");
    assert!(report["ate_m"]["rmse"].as_f64().unwrap() < 0.02, "{report}");
    // What is written can be evaluated.
    let outcome = workspace.must(&["evaluate", "broken/groundtruth.txt", "t.tum", "--json", "e.json"]);
    assert!(outcome.stdout.contains("alignment sim3"), "{}", outcome.stdout);
    let difference = workspace.json("e.json")["ate_m"]["rmse"].as_f64().unwrap()
        - report["ate_m"]["rmse"].as_f64().unwrap();
    assert!(difference.abs() < 1e-6);
}

#[test]
fn too_little_to_see_is_said_and_written() {
    let workspace = Workspace::new();
    let lines = clip_lines();
    sequence(&workspace, "three", &lines[..3], CAMERA);
    let black = flat_image(&workspace, "black.png", (320, 240), 0);
    let white = flat_image(&workspace, "white.png", (320, 240), 255);
    let flat: Vec<(String, String)> = (0..20)
        .map(|i| (format!("{}.0", 100 + i), if i % 2 == 0 { black.clone() } else { white.clone() }))
        .collect();
    sequence(&workspace, "flat", &flat, CAMERA);
    for (name, frames) in [("three", 3), ("flat", 20)] {
        let outcome = workspace.must(&["slam", name, "--json", "r.json", "--trajectory", "t.tum"]);
        assert!(outcome.stdout.contains("no map was started"), "{}", outcome.stdout);
        let report = workspace.json("r.json");
        assert_eq!((&report["frames"], &report["tracked"]), (&frames.into(), &0.into()));
        assert!(report["ate_m"].is_null() && report["initialized_at_s"].is_null());
        assert!(data_lines(&workspace.read("t.tum")).is_empty());
    }
}

#[test]
fn images_of_another_size_count_wherever_they_are() {
    let workspace = Workspace::new();
    let mut lines = clip_lines();
    lines.truncate(20);
    let small = flat_image(&workspace, "small.png", (160, 120), 90);
    for odd in [0, 1, 9] {
        lines[odd].1.clone_from(&small);
    }
    sequence(&workspace, "mixed", &lines, CAMERA);
    let outcome = workspace.must(&["slam", "mixed", "--json", "r.json"]);
    assert_eq!(workspace.json("r.json")["frames"], 20);
    assert_eq!(outcome.stdout.matches("left out: ").count(), 3, "{}", outcome.stdout);
}

#[test]
fn images_of_4k_are_made_smaller() {
    let workspace = Workspace::new();
    let large = flat_image(&workspace, "large.png", (3840, 2160), 90);
    let lines: Vec<(String, String)> = (0..2).map(|i| (format!("{}.0", 100 + i), large.clone())).collect();
    sequence(
        &workspace,
        "uhd",
        &lines,
        &CAMERA.replace("width: 320\nheight: 240", "width: 3840\nheight: 2160"),
    );
    let said = |scale: &[&str]| workspace.must(&[&["slam", "uhd"][..], scale].concat()).stdout;
    assert!(said(&[]).contains("images of 3840 x 2160 px are used at 1280 x 720 (--scale 1: as they are)"));
    assert!(!said(&["--scale", "1"]).contains("are used at"));
}

#[test]
fn gaps_and_unlikely_calibrations_are_warned_about() {
    let workspace = Workspace::new();
    let mut lines = clip_lines();
    lines.drain(20..40);
    let lines = &lines[..30];
    sequence(&workspace, "gap", lines, CAMERA);
    let outcome = workspace.must(&["slam", "gap"]);
    assert!(outcome.stdout.contains("note: a gap in the images"), "{}", outcome.stdout);
    sequence(&workspace, "wrong", lines, &CAMERA.replace("cx: 159.5", "cx: 900"));
    let outcome = workspace.must(&["slam", "wrong", "--until", "5"]);
    assert!(outcome.stdout.contains("principal point (900.0, 119.5) is outside"), "{}", outcome.stdout);
    sequence(
        &workspace,
        "large",
        lines,
        &CAMERA.replace("width: 320\nheight: 240", "width: 640\nheight: 480"),
    );
    let outcome = workspace.must(&["slam", "large", "--until", "0.1s"]);
    assert!(outcome.stdout.contains("640 x 480 px, these have 320 x 240"), "{}", outcome.stdout);
}

#[test]
fn sequences_that_do_not_exist_are_refused_in_a_line() {
    let workspace = Workspace::new();
    assert!(workspace.refused(&["slam", "nowhere"]).contains("nowhere"));
    fs::create_dir_all(workspace.path("empty")).unwrap();
    assert!(workspace.refused(&["slam", "empty"]).contains("rgb.txt (TUM RGB-D)"));
    assert!(workspace.refused(&["slam", "sim:moon"]).contains("room, hall, walking, kidnap"));
    sequence(&workspace, "desk", &clip_lines()[..5], &CAMERA.replace("fx: 262.5", "fx: wide"));
    let error = workspace.refused(&["slam", "desk"]);
    assert!(error.contains("camera.yaml: line 3") && error.contains("'wide'"), "{error}");
    workspace.write("good.yaml", CAMERA);
    workspace.must(&["slam", "desk", "--calibration", "good.yaml"]);
    assert!(
        workspace.refused(&["slam", "desk", "--calibration", "good.yaml", "--start", "99"]).contains("range")
    );
    let outcome = workspace.visloc(&["slam", "desk", "--start", "soon"]);
    assert!(outcome.code == 2 && outcome.stderr.contains("4.5s"), "{}", outcome.stderr);
}

#[test]
fn every_map_has_pictures_of_its_own() {
    let workspace = Workspace::new();
    let lines = clip_lines();
    let dark = flat_image(&workspace, "dark.png", (320, 240), 0);
    // No place of a room is recognized in its mirror image: two maps, which nothing joins.
    let mirrored = lines.iter().enumerate().map(|(i, (_, file))| {
        let mut image = read_image(Path::new(file)).unwrap();
        image.data_mut().chunks_exact_mut(3 * 320).for_each(|row| {
            let pixels: Vec<[u8; 3]> =
                row.chunks_exact(3).rev().map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
            row.copy_from_slice(pixels.as_flattened());
        });
        let path = workspace.path(&format!("mirrored-{i}.png"));
        save_png(&image, &path).unwrap();
        path.display().to_string()
    });
    let files: Vec<String> = lines.iter().map(|(_, file)| file.clone()).collect();
    let files = files.into_iter().chain(std::iter::repeat_n(dark, 45)).chain(mirrored);
    let stamped = files.enumerate().map(|(i, file)| (format!("{:.6}", i as f64 / 30.0), file));
    sequence(&workspace, "rooms", &stamped.collect::<Vec<_>>(), CAMERA);
    fs::remove_file(workspace.path("rooms/groundtruth.txt")).unwrap();
    fs::create_dir_all(workspace.path("plots")).unwrap();
    workspace.must(&["slam", "rooms", "--plots", "plots", "--json", "r.json"]);
    assert_eq!(workspace.json("r.json")["maps"].as_array().map(Vec::len), Some(2));
    for (name, title) in [("trajectory", "rooms, map 1 of 2"), ("trajectory-2", "rooms, map 2 of 2")] {
        assert!(workspace.read(&format!("plots/{name}.svg")).contains(title), "{name}");
        assert!(workspace.path(&format!("plots/{name}-side.png")).exists(), "{name}");
    }
    // Another run has no more maps than it has.
    workspace.must(&["slam", "rooms", "--until", "60", "--plots", "plots"]);
    assert!(
        !workspace.path("plots/trajectory-2.svg").exists()
            && !workspace.path("plots/trajectory-2-side.png").exists()
    );
    assert!(!workspace.read("plots/trajectory.svg").contains("map 1 of"));
}

#[test]
fn the_demo_leaves_every_file() {
    let workspace = Workspace::new();
    let outcome = workspace.must(&["demo", "slam", "--frames", "40", "--out", "d"]);
    assert!(outcome.stdout.contains("the map was started") && outcome.stdout.contains("Next:"));
    for file in ["trajectory.png", "trajectory-side.svg", "courses.png", "frame-00000.png", "map.ply"] {
        assert!(workspace.path(&format!("d/{file}")).exists(), "{file}");
    }
    assert!(workspace.json("d/summary.json")["ate_m"]["rmse"].as_f64().unwrap() < 0.05);
}

#[test]
fn experiments_show_published_and_measured_figures() {
    let workspace = Workspace::new();
    sequence(&workspace, "mh_01_clip", &clip_lines(), CAMERA);
    let run = ["experiment", "slam-dynamic", "mh_01_clip", "--runs", "1", "--out", "x"];
    let outcome = workspace.must(&run);
    assert!(
        outcome.stdout.contains("MH01, config1") && outcome.stdout.contains("F3W is not here"),
        "{}",
        outcome.stdout
    );
    let records = workspace.json("x/report.json")["cells"][0]["records"].as_array().unwrap().len();
    assert_eq!(records, 1);
    let outcome = workspace.must(&["experiment", "slam-compare", "mh_01_clip", "--runs", "1"]);
    assert!(outcome.stdout.contains("0.147 | "), "{}", outcome.stdout);
    assert!(workspace.path("x/mh_01_clip-errors.png").exists());
}
