//! `visloc calibrate`, `check-camera`, `camera` and `calibrate-robot`.

use crate::support::{Workspace, write_program};

const CAMERA: &str = "model = \"radial-tangential\"\nsize_px = [480, 360]\nfocal_px = [391.0, 392.3]\ncenter_px = [242.9, \
                      177.3]\ndistortion = [-0.25, 0.09, 0.0008, -0.0006, 0.0]\n";
const BOARD: [&str; 4] = ["--size", "9x6", "--square", "0.03"];

fn rendered(count: &str) -> Workspace {
    let workspace = Workspace::new();
    workspace.write("truth.toml", CAMERA);
    let args =
        [&["camera", "render", "truth.toml", "--out", "photos", "--count", count], &BOARD[..]].concat();
    assert_eq!(workspace.visloc(&args).code, 0);
    workspace
}

#[test]
fn rendered_pictures_are_not_mixed_with_those_of_others() {
    let workspace = rendered("1");
    workspace.write("photos/000.png", "somebody's own");
    let error =
        workspace.refused(&[&["camera", "render", "truth.toml", "--out", "photos"], &BOARD[..]].concat());
    assert!(error.contains("photos: expected a new or empty folder"), "{error}");
    assert_eq!(workspace.read("photos/000.png"), "somebody's own");
}

#[test]
fn a_camera_comes_out_of_pictures_and_goes_through_every_form() {
    let workspace = rendered("14");
    let outputs = ["--out", "camera.toml", "--ros", "info.yaml", "--report", "report", "--json", "all.json"];
    let run =
        workspace.visloc(&[&["calibrate", "photos", "--model", "radtan4"], &BOARD[..], &outputs].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("14 images of 480 x 360 px"), "{}", run.stdout);
    let report = workspace.json("all.json");
    let fx = report["camera"]["focal_px"][0].as_f64().unwrap();
    assert!((fx / 391.0 - 1.0).abs() < 0.002, "{fx}");
    assert!(report["quality"]["rms_px"].as_f64().unwrap() < 0.1);
    for picture in ["coverage", "vectors", "residuals", "distances", "corners"] {
        assert!(workspace.read("report/report.md").contains(&format!("{picture}.png")));
        assert!(workspace.path(&format!("report/{picture}.png")).is_file());
    }
    for (format, name) in [("kalibr", "k.yaml"), ("opencv", "o.yml"), ("ros", "r.yaml"), ("toml", "t.toml")] {
        let convert = workspace.visloc(&["camera", "convert", "camera.toml", name, "--format", format]);
        assert_eq!(convert.code, 0, "{}", convert.stderr);
        let check = workspace.visloc(&["check-camera", name, "photos"]);
        assert_eq!(check.code, 0, "{name}: {} {}", check.stdout, check.stderr);
    }
}

/// The video is damaged behind its first image, and one picture is too few.
#[cfg(unix)]
#[test]
fn what_is_damaged_is_told_also_when_the_rest_is_not_enough() {
    let workspace = Workspace::new();
    workspace.write("clip.mp4", "");
    let script = "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\n\
                  for i in 1 2; do printf 'P6 64 48 255\\n'; head -c $((9216 / i)) /dev/zero; done\n";
    write_program(&workspace.path("cut"), script);
    let run = workspace.visloc(&[&["calibrate", "clip.mp4", "--ffmpeg", "./cut"], &BOARD[..]].concat());
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stdout.contains("note: clip.mp4: the last image is cut off"), "{}", run.stdout);
    assert!(run.stderr.contains("error: clip.mp4: expected at least 3 usable pictures"), "{}", run.stderr);
}

#[test]
fn bad_input_is_named() {
    let workspace = rendered("2");
    let fails = |args: &[&str], expected: &str| {
        let run = workspace.visloc(args);
        assert_ne!(run.code, 0, "{args:?}");
        assert!(run.stderr.contains(expected), "{args:?}: {}", run.stderr);
    };
    for command in [
        &["calibrate", "photos", "--size", "9x6", "--square", "0.03"][..],
        &["check-camera", "truth.toml", "photos"],
    ] {
        fails(&[command, &["--fps", "10"]].concat(), "--fps: photos is a folder of images");
        fails(&[command, &["--image-topic", "/a"]].concat(), "--image-topic: photos is a folder of images");
    }
    fails(
        &[&["calibrate", "photos"], &BOARD[..]].concat(),
        "expected at least 3 usable pictures of the board, found 2",
    );
    fails(
        &["calibrate", "photos", "--size", "8x6", "--square", "0.03"],
        "expected a grid of 8 x 6 inner corners, found 9 x 6",
    );
    fails(&["calibrate", "photos", "--size", "9", "--square", "0.03"], "expected columns x rows");
    fails(&["calibrate", "photos", "--size", "9x6", "--square=-1"], "expected a number from 0.0001 to 10");
    fails(
        &["calibrate", "nowhere", "--size", "9x6", "--square", "0.03"],
        "nowhere: expected a folder of images",
    );
    fails(
        &["calibrate", ".", "--size", "9x6", "--square", "0.03"],
        "expected PNG or JPEG images, found none",
    );
    fails(&["camera", "convert", "truth.toml", "out.txt"], "expected .toml or .yaml");
    for (name, format, ending) in [("out.yaml", "toml", ".toml"), ("out.toml", "kalibr", ".yaml")] {
        let expected = format!("{name}: expected a name that ends in {ending}");
        fails(&["camera", "convert", "truth.toml", name, "--format", format], &expected);
    }
    workspace.write("wide.toml", &CAMERA.replace("480, 360", "640, 360"));
    fails(&["check-camera", "wide.toml", "photos", "--json", "check.json"], "cannot be right");
    assert_eq!(workspace.json("check.json")["verdict"], "wrong");
    workspace.write("robot.toml", "[odometry]\nscale = [0.0, 1.0, 1.0]\n");
    fails(&["localize", "sim:still", "--robot", "robot.toml"], "odometry.scale");
}

#[test]
fn a_wrong_mounting_is_found() {
    let workspace = Workspace::new();
    workspace
        .write("wrong.toml", "[camera]\npitch_down_deg = 2.0\nroll_clockwise_deg = -1.5\nheight_m = 0.02\n");
    let args = [
        "calibrate-robot",
        "sim:tour",
        "--frames",
        "900",
        "--passes",
        "2",
        "--out",
        "robot.toml",
        "--json",
        "robot.json",
    ];
    let run = workspace.visloc(&[&args[..], &["--robot", "wrong.toml"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    // The simulated robot's own errors change slowly with up to half a degree; on average they are nearly nothing.
    let camera = &workspace.json("robot.json")["correction"]["camera"];
    let value = |key: &str| camera[key].as_f64().unwrap();
    assert!(value("pitch_down_deg").abs() < 0.4 && value("roll_clockwise_deg").abs() < 0.4, "{camera}");
    assert!(value("height_m").abs() < 0.012, "{camera}");
    let localize = workspace.visloc(&["localize", "sim:tour", "--frames", "60", "--robot", "robot.toml"]);
    assert_eq!(localize.code, 0, "{}", localize.stderr);
}

/// The simulated camera is where it is reported, so a file that turns it is what `localize` has to undo.
#[test]
fn localizing_finds_the_turn_of_the_camera_and_keeps_it() {
    let workspace = Workspace::new();
    workspace.write("wrong.toml", "[camera]\npitch_down_deg = 2.0\nroll_clockwise_deg = -1.5\n");
    let args = ["localize", "sim:tour", "--frames", "450", "--robot", "wrong.toml"];
    let outputs = ["--robot-out", "robot.toml", "--json", "r.json"];
    let run = workspace.must(&[&args[..], &outputs].concat());
    assert!(run.stdout.contains("farther down than reported"), "{}", run.stdout);
    let error = &workspace.json("r.json")["camera_error"];
    let found = |key: &str, part: &str| error[key][part].as_f64().unwrap();
    assert!(
        (found("pitch_down_deg", "mean") + 2.0).abs() < 3.0 * found("pitch_down_deg", "sigma"),
        "{error}"
    );
    assert!((found("roll_clockwise_deg", "mean") - 1.5).abs() < 3.0 * found("roll_clockwise_deg", "sigma"));
    assert_eq!(error["is_confirmed"], true);
    let kept: toml::Table = std::fs::read_to_string(workspace.path("robot.toml")).unwrap().parse().unwrap();
    let pitch = kept["camera"]["pitch_down_deg"].as_float().unwrap();
    assert!(pitch.abs() < 0.7, "what is left of 2 degrees: {pitch}");
}

#[test]
fn a_camera_is_found_from_its_own_motion_without_a_board() {
    let workspace = Workspace::new();
    let clip = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip/rgb");
    let clip = clip.to_str().unwrap();
    let run = workspace.must(&[
        "calibrate",
        clip,
        "--out",
        "camera.toml",
        "--ros",
        "info.yaml",
        "--json",
        "c.json",
    ]);
    assert!(run.stdout.contains("60 images of 320 x 240 px, 60 followed"), "{}", run.stdout);
    let report = workspace.json("c.json");
    let focal = report["camera"]["focal_px"][0].as_f64().unwrap();
    assert!((focal / 262.5 - 1.0).abs() < 0.05, "{focal}");
    assert_eq!(report["quality"]["source"], "motion");
    assert!(workspace.read("info.yaml").contains("plumb_bob"));
    workspace.must(&["slam", clip, "--camera", "camera.toml"]);
    let refused = |more: &[&str]| workspace.refused(&[&["calibrate", clip][..], more].concat());
    assert!(refused(&["--square", "0.03"]).contains("--size"));
    assert!(refused(&["--report", "r"]).contains("--report: expected a board"));
    assert!(refused(&["--model", "radtan4"]).contains("--model: expected a board"));
}

#[test]
fn where_nothing_says_what_camera_it_was_it_is_found_first() {
    let workspace = Workspace::new();
    let clip = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip/rgb");
    let clip = clip.to_str().unwrap();
    let slam = workspace.must(&["slam", clip, "--json", "slam.json", "--save", "desk.vmap"]);
    assert!(slam.stdout.contains("60 images of 320 x 240 px, 60 followed"), "{}", slam.stdout);
    assert!(slam.stdout.contains("--out camera.toml keeps"), "{}", slam.stdout);
    assert_eq!(workspace.json("slam.json")["coverage"], 1.0);
    let localize = workspace.must(&["localize", clip, "--map", "desk.vmap", "--json", "there.json"]);
    assert!(localize.stdout.contains("localized in 100.0 %"), "{}", localize.stdout);
    // Images that do not tell it, and poses that another camera had.
    let few = workspace.refused(&["slam", clip, "--frames", "3"]);
    assert!(few.contains("expected a calibration") && few.contains("can be followed in"), "{few}");
    workspace.write("poses.tum", "0 0 0 0 0 0 0 1\n");
    let given = workspace.refused(&["slam", clip, "--poses", "poses.tum", "--save", "m.vmap"]);
    assert!(given.contains("expected a calibration"), "{given}");
}
