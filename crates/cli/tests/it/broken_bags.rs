//! Recordings with something wrong in them.

use std::fs;

use visloc_core::{RgbImage, Timestamp, geom::PlanarPose};

use crate::support::{MAP, Workspace, data_lines, excerpt, excerpt_text};

#[test]
fn missing_bag() {
    let error = Workspace::new().refused(&["localize", "nowhere.mcap", "--map", MAP]);
    assert!(error.contains("nowhere.mcap"), "{error}");
}

#[test]
fn a_bag_needs_a_map() {
    let error = Workspace::new().refused(&["localize", &excerpt_text("R1")]);
    assert!(error.contains("--map"), "{error}");
}

#[test]
fn a_file_that_is_no_bag() {
    let workspace = Workspace::new();
    workspace.write("text.mcap", "hello");
    let error = workspace.refused(&["localize", "text.mcap", "--map", MAP]);
    assert!(error.contains("text.mcap") && error.contains("MCAP"), "{error}");
}

#[test]
fn what_came_before_the_cut_stays() {
    let workspace = Workspace::new();
    let bytes = fs::read(excerpt("R1")).unwrap();
    fs::write(workspace.path("cut.mcap"), &bytes[..bytes.len() * 6 / 10]).unwrap();
    let out = ["--trajectory", "r.tum", "--json", "r.json"];
    let error = workspace.refused(&[&["localize", "cut.mcap", "--map", MAP], &out[..]].concat());
    assert!(error.contains("cut.mcap") && error.contains("byte"), "{error}");
    let num_poses = data_lines(&workspace.read("r.tum")).len();
    assert!((30..90).contains(&num_poses), "{num_poses}");
    assert_eq!(workspace.json("r.json")["frames"], num_poses);
}

#[test]
fn a_wrong_frame_lists_what_there_is() {
    let bag = excerpt_text("R1");
    for option in ["--base-frame", "--camera-frame"] {
        let outcome = Workspace::new().visloc(&["localize", &bag, "--map", MAP, option, "nowhere"]);
        assert_eq!(outcome.code, 1);
        let wanted = format!("set {option} to one of: base_footprint, camera_optical");
        assert!(
            outcome.stderr.contains("no frame 'nowhere'") && outcome.stderr.contains(&wanted),
            "{}",
            outcome.stderr
        );
        assert!(!outcome.stdout.contains("knew the place"), "{}", outcome.stdout);
        let is_counted = outcome.stdout.contains("left out 90 of /camera/image/compressed\n");
        assert!(is_counted && !outcome.stdout.contains("nowhere"), "said once: {}", outcome.stdout);
    }
}

#[test]
fn a_wrong_topic_lists_what_there_is() {
    let bag = excerpt_text("R1");
    let error = Workspace::new().refused(&["localize", &bag, "--map", MAP, "--image-topic", "/eye"]);
    assert!(error.contains("/eye") && error.contains("/camera/image/compressed"), "{error}");
}

#[test]
fn a_corrupt_image_is_left_out_and_counted() {
    let workspace = Workspace::new();
    workspace.rewrite_messages("corrupt.mcap", |topic, index, data| {
        if topic == "/camera/image/compressed" && (index == 40 || index == 41) {
            let half = data.len() / 2;
            data[half..].fill(0);
        }
    });
    let outcome = workspace.must(&["localize", "corrupt.mcap", "--map", MAP, "--json", "r.json"]);
    let report = workspace.json("r.json");
    assert_eq!((report["frames"].as_u64(), report["skipped"]["count"].as_u64()), (Some(88), Some(2)));
    assert!(outcome.stdout.contains("left out 2 of /camera/image/compressed"), "{}", outcome.stdout);
}

#[test]
fn images_of_another_size_than_the_calibration() {
    let workspace = Workspace::new();
    let shrink = |frame: &mut visloc_core::SourceFrame| frame.frame.image = RgbImage::new(160, 120);
    workspace.bag("one.mcap", 12, |index, frame| {
        if index == 5 {
            shrink(frame);
        }
    });
    workspace.must(&["localize", "one.mcap", "--map", MAP, "--json", "r.json"]);
    let report = workspace.json("r.json");
    assert_eq!((report["frames"].as_u64(), report["skipped"]["count"].as_u64()), (Some(11), Some(1)));
    workspace.bag("all.mcap", 5, |_, frame| shrink(frame));
    let error = workspace.refused(&["localize", "all.mcap", "--map", MAP]);
    assert!(error.contains("160") && error.contains("320"), "{error}");
}

#[test]
fn odometry_that_is_not_a_number() {
    let workspace = Workspace::new();
    workspace.bag("nan.mcap", 12, |index, frame| {
        if index == 5 {
            frame.frame.odometry = Some(PlanarPose { x_m: f64::NAN, y_m: 0.0, yaw_rad: 0.0 });
        }
    });
    workspace.must(&["localize", "nan.mcap", "--map", MAP, "--json", "r.json", "--estimates", "r.csv"]);
    assert_eq!(workspace.json("r.json")["skipped"]["count"], 1);
    assert!(!workspace.read("r.csv").contains("NaN"));
}

#[test]
fn time_that_goes_back() {
    let workspace = Workspace::new();
    workspace.bag("back.mcap", 12, |index, frame| {
        if index == 6 {
            frame.frame.at = Timestamp::from_nanos(frame.frame.at.nanos() - 5_000_000_000);
        }
    });
    workspace.must(&["localize", "back.mcap", "--map", MAP, "--json", "r.json", "--trajectory", "r.tum"]);
    let text = workspace.read("r.tum");
    let times: Vec<f64> =
        data_lines(&text).iter().map(|line| line.split(' ').next().unwrap().parse().unwrap()).collect();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
    assert!(workspace.json("r.json")["skipped"]["count"].as_u64() >= Some(1));
}
