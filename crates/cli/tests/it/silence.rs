//! Runs that localize or track nothing, or almost nothing, say why; good runs do not.

use nalgebra::{Rotation3, Vector3};
use serde_json::Value;
use visloc_core::{
    Frame, GroundContact, RgbImage,
    geom::{Camera, Rigid3},
};

use crate::support::{MAP, Outcome, Workspace, excerpt_text};

/// The codes of the diagnosis in `r.json`, whose sentences stand on the screen as well.
fn codes(workspace: &Workspace, outcome: &Outcome) -> Vec<String> {
    let report = workspace.json("r.json");
    let findings = report["diagnosis"].as_array().unwrap_or_else(|| panic!("no diagnosis in {report}"));
    assert_eq!(outcome.stdout.contains("Why so little was"), !findings.is_empty(), "{}", outcome.stdout);
    let code = |finding: &Value| {
        let text = |key: &str| finding[key].as_str().unwrap().to_owned();
        assert!(outcome.stdout.contains(&text("sentence")) && outcome.stdout.contains(&text("advice")));
        assert!((0.0..=1.0).contains(&finding["share"].as_f64().unwrap()));
        text("code")
    };
    findings.iter().map(code).collect()
}

fn localize(workspace: &Workspace, source: &str, options: &[&str]) -> Vec<String> {
    let base = ["localize", source, "--json", "r.json"];
    codes(workspace, &workspace.must(&[&base[..], options].concat()))
}

fn recolored(image: &RgbImage, color: impl Fn([u8; 3]) -> [u8; 3]) -> RgbImage {
    let mut changed = RgbImage::new(image.width(), image.height());
    for y in 0..image.height() {
        for x in 0..image.width() {
            changed.set(x, y, color(image.get(x, y)));
        }
    }
    changed
}

/// The camera looks this much farther down, and is this much higher.
fn moved(frame: &mut Frame, tilt_deg: f64, up_m: f64) {
    // About the camera's own x axis, which points to the right: the head may be turned.
    let tilt = Rotation3::from_axis_angle(&Vector3::x_axis(), -tilt_deg.to_radians());
    let rotation = Rotation3::from_matrix_unchecked(*frame.robot_from_camera.rotation()) * tilt;
    let translation = frame.robot_from_camera.translation() + Vector3::new(0.0, 0.0, up_m);
    frame.robot_from_camera = Rigid3::new(rotation, translation);
}

fn with_focal(frame: &mut Frame, focal_px: f64) {
    let size_px = frame.camera.size_px();
    frame.camera = Camera::pinhole(size_px, (focal_px, focal_px), frame.camera.center_px()).unwrap();
}

#[test]
fn each_reason_for_no_place_is_named_and_no_other() {
    type Change = fn(&mut Frame);
    let cases: [(&str, Change); 9] = [
        ("gray-images", |frame| {
            frame.image = recolored(&frame.image, |[r, g, b]| {
                [((2 * u32::from(r) + 5 * u32::from(g) + u32::from(b)) / 8) as u8; 3]
            });
        }),
        ("black-images", |frame| frame.image = recolored(&frame.image, |rgb| rgb.map(|v| v / 60))),
        ("overexposed-images", |frame| frame.image = recolored(&frame.image, |_| [255; 3])),
        ("no-carpet", |frame| {
            // No color of this order of levels is green.
            frame.image = recolored(&frame.image, |mut rgb| {
                rgb.sort_unstable_by(|a, b| b.cmp(a));
                rgb
            });
        }),
        ("camera-up", |frame| moved(frame, -70.0, 0.0)),
        ("camera-down", |frame| moved(frame, 65.0, 0.0)),
        ("camera-on-ground", |frame| moved(frame, 0.0, -0.6)),
        ("calibration", |frame| with_focal(frame, 4000.0)),
        ("lifted", |frame| frame.ground_contact = Some(GroundContact::Pressure([0.0; 8]))),
    ];
    let workspace = Workspace::new();
    for (code, change) in cases {
        workspace.bag("changed.mcap", 90, |_, next| change(&mut next.frame));
        assert_eq!(localize(&workspace, "changed.mcap", &["--map", MAP]), [code]);
        std::fs::remove_file(workspace.path("changed.mcap")).unwrap();
    }
}

#[test]
fn the_wrong_map_is_named() {
    let workspace = Workspace::new();
    assert_eq!(localize(&workspace, &excerpt_text("R1"), &["--map", "office"]), ["field-images"]);
    assert_eq!(localize(&workspace, &excerpt_text("O1"), &["--map", MAP]), ["no-carpet"]);
    let map = excerpt_text("O1").replace("O1-excerpt.mcap", "O1-map.yaml");
    let text = std::fs::read_to_string(map).unwrap();
    workspace.write("no-doors.yaml", text.split("doors:").next().unwrap());
    let found = localize(&workspace, &excerpt_text("O1"), &["--map", "no-doors.yaml"]);
    assert_eq!(found, ["map-without-doors"]);
}

#[test]
fn a_field_that_looks_alike_from_both_halves_asks_for_one() {
    let workspace = Workspace::new();
    let run = ["--frames", "240"];
    assert_eq!(localize(&workspace, "sim:tour-2024", &run), ["point-symmetric"]);
    let half = [&run[..], &["--start", "half:negative"]].concat();
    assert_eq!(localize(&workspace, "sim:tour-2024", &half), [""; 0]);
}

#[test]
fn a_start_that_the_images_contradict_or_cannot_confirm_is_named() {
    let workspace = Workspace::new();
    let said = |source: &str, map: &str, start: &str| {
        let run = ["localize", source, "--map", map, "--frames", "60", "--start", start];
        let stdout = workspace.must(&run).stdout;
        (stdout.contains("--start does not hold"), stdout.contains("the half is that of --start"))
    };
    // The robot begins at x -1.43 m, and the goals have two colors.
    let bag = excerpt_text("R1");
    for (start, does_hold) in [
        ("half:negative", true),
        ("half:positive", false),
        ("pose:-1.43,1.09,-153", true),
        ("pose:1.43,-1.09,27", false),
        ("side-lines:negative", false),
    ] {
        assert_eq!(said(&bag, MAP, start), (!does_hold, false), "{start}");
    }
    for half in ["half:negative", "half:positive"] {
        assert_eq!(said("sim:tour-2024", "robocup-spl-2024", half), (false, true), "{half}");
    }
}

#[test]
fn odometry_in_another_unit_is_named() {
    let workspace = Workspace::new();
    workspace.bag("changed.mcap", 90, |_, next| {
        let odometry = next.frame.odometry.as_mut().unwrap();
        (odometry.x_m, odometry.y_m) = (1000.0 * odometry.x_m, 1000.0 * odometry.y_m);
    });
    let said = |source: &str| workspace.must(&["localize", source, "--map", MAP]).stdout;
    assert!(said("changed.mcap").contains("the odometry jumps in"), "millimeters");
    assert!(!said(&excerpt_text("R1")).contains("the odometry jumps"));
}

#[test]
fn good_runs_need_no_reason_and_short_ones_say_that_they_are() {
    let workspace = Workspace::new();
    for name in ["R1", "R2"] {
        assert_eq!(localize(&workspace, &excerpt_text(name), &["--map", MAP]), [""; 0], "{name}");
    }
    for name in ["O1", "O2"] {
        let bag = excerpt_text(name);
        let map = bag.replace("-excerpt.mcap", "-map.yaml");
        assert_eq!(localize(&workspace, &bag, &["--map", &map]), [""; 0], "{name}");
    }
    assert_eq!(localize(&workspace, "sim:tour", &["--frames", "240"]), [""; 0]);
    let short = ["--map", MAP, "--frames", "4"];
    assert_eq!(localize(&workspace, &excerpt_text("R1"), &short), ["short-run"]);
}

fn slam(workspace: &Workspace, source: &str, options: &[&str]) -> Vec<String> {
    let base = ["slam", source, "--json", "r.json"];
    codes(workspace, &workspace.must(&[&base[..], options].concat()))
}

#[test]
fn each_reason_for_no_track_is_named() {
    let workspace = Workspace::new();
    type Change = fn(usize, &mut Frame);
    let cases: [(&str, Change); 4] = [
        ("black-images", |_, frame| frame.image = recolored(&frame.image, |rgb| rgb.map(|v| v / 60))),
        ("overexposed-images", |_, frame| frame.image = recolored(&frame.image, |_| [255; 3])),
        ("no-texture", |_, frame| frame.image = recolored(&frame.image, |_| [90; 3])),
        ("standing-still", |_, frame| frame.image = stripes(0)),
    ];
    for (code, change) in cases {
        workspace.bag("changed.mcap", 60, |index, next| change(index, &mut next.frame));
        assert_eq!(slam(&workspace, "changed.mcap", &[]), [code]);
        std::fs::remove_file(workspace.path("changed.mcap")).unwrap();
    }
    // Ten images a second of a head that turns from side to side over plain carpet, without odometry.
    let found = slam(&workspace, &excerpt_text("R1"), &["--odometry-topic", ""]);
    assert_eq!(found, ["too-fast", "no-texture"]);
    let clip = excerpt_text("R1").replace("R1-excerpt.mcap", "desk-clip");
    assert_eq!(slam(&workspace, &clip, &[]), [""; 0]);
}

#[test]
fn who_was_never_found_in_a_map_was_not_lost_in_it() {
    let workspace = Workspace::new();
    let clip = excerpt_text("R1").replace("R1-excerpt.mcap", "desk-clip");
    workspace.must(&["slam", &clip, "--save", "desk.vmap"]);
    let elsewhere =
        ["slam", "sim:room", "--until", "20", "--json", "r.json", "--load", "desk.vmap", "--fixed"];
    let outcome = workspace.must(&elsewhere);
    assert_eq!(codes(&workspace, &outcome), ["not-recognized"]);
    let said = "tracked 0.0 %, lost 0 times, found again 0 times";
    assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    assert!(outcome.stdout.contains("the camera was never found in desk.vmap"), "{}", outcome.stdout);
}

/// Squares of all brightnesses.
fn stripes(shift: u32) -> RgbImage {
    let mut image = RgbImage::new(320, 240);
    for y in 0..240 {
        for x in 0..320 {
            let (column, row) = ((x + shift) / 12, y / 12);
            let value = (column * 73 + row * 151 + column * row * 37) % 200 + 30;
            image.set(x, y, [value as u8; 3]);
        }
    }
    image
}
