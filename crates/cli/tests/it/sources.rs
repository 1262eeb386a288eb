//! Sources from outside: the list, typing mistakes, recordings of recordings, results in bags.

use std::{collections::BTreeSet, fs, path::Path};

use visloc_core::{RgbImage, Source};
use visloc_io::{
    bag::{BagMessages, BagPictures, BagReader, BagTopics},
    image_codec::{read_image, save_png},
    sources::SourceOption,
};

use crate::support::{MAP, Workspace, data_lines, excerpt, excerpt_text, write_program};

#[test]
fn the_list_says_what_works_here() {
    let workspace = Workspace::new();
    let text = workspace.must(&["sources", "--ffmpeg", "no-such-program"]).stdout;
    assert!(
        text.contains("v4l2:DEVICE") && text.contains("not usable here: ffmpeg ('no-such-program')"),
        "{text}"
    );
    let json = workspace.must(&["sources", "--json"]).stdout;
    let kinds: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
    let bag = kinds.iter().find(|kind| kind["name"] == "ROS bag").unwrap();
    assert_eq!((&bag["usable"], &bag["live"]), (&true.into(), &false.into()));
    assert!(kinds.iter().any(|kind| kind["schemes"][0] == "ros2"));
}

#[test]
fn mistakes_name_the_nearest() {
    let workspace = Workspace::new();
    let error = workspace.refused(&["slam", "vidoe:clip.mp4"]);
    assert!(error.contains("did you mean 'video:'?"), "{error}");
    let error = workspace.refused(&["localize", "sim:robocop"]);
    assert!(error.contains("did you mean 'robocup'?"), "{error}");
    let error = workspace.refused(&["localize", &excerpt_text("R1")]);
    assert!(error.contains("needs a map: --map"), "{error}");
    let error = workspace.refused(&["slam", "ros2:image"]);
    assert!(error.contains("expected a topic such as /camera/image_raw"), "{error}");
    workspace.write("clip.mp4", "");
    let error = workspace.refused(&["slam", "clip.mp4", "--ffmpeg", "./no-such-program"]);
    assert!(error.contains("cannot be started") && error.contains("--ffmpeg PATH"), "{error}");
    // A video without images says nothing of its camera, and is to blame itself.
    write_program(&workspace.path("broken"), "#!/bin/sh\nexit 1\n");
    let error = workspace.refused(&["slam", "clip.mp4", "--ffmpeg", "./broken"]);
    assert!(error.contains("after 0 images") && !error.contains("expected a calibration"), "{error}");
}

/// A copy of a bag goes another way than all other recordings, on which the library tries every option.
#[test]
fn every_option_changes_the_copy_of_a_bag_or_is_refused() {
    let workspace = Workspace::new();
    workspace.write(
        "camera.toml",
        "model = \"pinhole\"\nsize_px = [320, 240]\nfocal_px = [300, 300]\ncenter_px = [160, 120]\n",
    );
    let bag = excerpt_text("R1");
    workspace.must(&["record", &bag, "--out", "whole.mcap"]);
    let whole = fs::read(workspace.path("whole.mcap")).unwrap();
    let help = workspace.must(&["record", "--help"]).stdout;
    let mut num_tried = 0;
    for option in SourceOption::ALL {
        let value = match option {
            SourceOption::Camera => "camera.toml",
            SourceOption::Urdf | SourceOption::Topics => "nothing.xml",
            SourceOption::ImageTopic => "/camera/image/compressed",
            SourceOption::CameraInfoTopic => "/camera/camera_info",
            SourceOption::OdometryTopic => "/odom",
            SourceOption::TruthTopic => "/ground_truth/pose",
            SourceOption::BaseFrame | SourceOption::CameraFrame => "nowhere",
            SourceOption::Mount => "0.4",
            SourceOption::ImageQos => "reliable",
            SourceOption::Ffmpeg => "./no-such-program",
            _ => "7",
        };
        if !help.contains(&format!("{} ", option.flag())) {
            continue;
        }
        num_tried += 1;
        let out = format!("{num_tried}.mcap");
        let run = workspace.visloc(&["record", &bag, "--out", &out, option.flag(), value]);
        let is_changed = fs::read(workspace.path(&out)).is_ok_and(|copy| copy != whole);
        let is_named = run.stderr.contains(option.flag()) || run.stderr.contains(value);
        assert!(if run.code == 0 { is_changed } else { is_named }, "{}: {}", option.flag(), run.stderr);
    }
    assert!(num_tried > 15, "{num_tried}");
}

#[test]
fn a_recording_of_a_camera_alone_is_recorded_on_demand() {
    let workspace = Workspace::new();
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip");
    workspace.must(&["record", clip, "--out", "clip.mcap", "--frames", "3"]);
    let again = ["record", "clip.mcap", "--out", "again.mcap", "--images", "png"];
    let error = workspace.refused(&again);
    assert!(error.contains("--images-only"), "{error}");
    let said = workspace.must(&[&again[..], &["--images-only"]].concat()).stdout;
    assert!(said.contains("3 images"), "{said}");
}

/// Without what makes a robot of them the images would be those of any camera.
#[test]
fn names_that_a_robot_lacks_are_refused_by_slam() {
    let workspace = Workspace::new();
    for (option, name) in [
        ("--odometry-topic", "/odm"),
        ("--truth-topic", "/nothing"),
        ("--base-frame", "base_footprnt"),
        ("--camera-frame", "nothing"),
    ] {
        let error = workspace.refused(&["slam", &excerpt_text("R1"), option, name]);
        assert!(error.contains(&format!("'{name}'")), "{error}");
    }
}

#[test]
fn a_recording_of_a_recording_gives_the_same_poses() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    workspace.must(&["record", &bag, "--out", "copy.mcap", "--images", "png", "--frames", "30"]);
    for (bag, estimates) in [(bag.as_str(), "first.csv"), ("copy.mcap", "second.csv")] {
        workspace.must(&["localize", bag, "--map", MAP, "--frames", "30", "--estimates", estimates]);
    }
    let [first, second] = ["first.csv", "second.csv"].map(|name| workspace.read(name));
    assert_eq!(first.lines().count(), 31);
    // What is written as a float of 64 bits and a quaternion comes back nearly the same.
    let last_x =
        |text: &str| -> f64 { text.lines().last().unwrap().split(',').nth(1).unwrap().parse().unwrap() };
    assert!((last_x(&first) - last_x(&second)).abs() < 1e-3);
}

#[test]
fn tours_and_bags_without_a_robot_are_recorded_as_pictures() {
    let workspace = Workspace::new();
    workspace.must(&["record", "sim:room", "--out", "room.mcap", "--frames", "3"]);
    let pictures = BagPictures::open(workspace.path("room.mcap"), &BagTopics::default()).unwrap();
    assert_eq!(pictures.status().num_items, Some(3));
    workspace.must(&["record", &excerpt_text("R1"), "--out", "eye", "--images-only", "--frames", "3"]);
    let pictures = BagPictures::open(workspace.path("eye"), &BagTopics::default()).unwrap();
    assert_eq!(pictures.camera().unwrap().size_px(), (320, 240));
    assert!(BagReader::open(workspace.path("eye"), BagTopics::default()).is_err(), "there is no tf");
}

#[test]
fn an_image_of_another_size_is_left_out_of_what_is_written() {
    let workspace = Workspace::new();
    fs::create_dir(workspace.path("im")).unwrap();
    for (name, width) in [("0.png", 64), ("1.png", 32), ("2.png", 32), ("3.png", 64), ("4.png", 32)] {
        save_png(&RgbImage::new(width, 3 * width / 4), &workspace.path(&format!("im/{name}"))).unwrap();
    }
    for out in [&["record", "im", "--out", "x.mcap"], &["extract", "im", "--out", "d"]] {
        let said = workspace.must(out).stdout;
        assert!(said.contains("3 images"), "{said}");
        assert!(said.contains("0.png") && said.contains("expected 32 x 24 px, found 64 x 48"), "{said}");
    }
}

#[test]
fn recordings_in_one_folder_are_named() {
    let workspace = Workspace::new();
    fs::create_dir(workspace.path("two")).unwrap();
    for name in ["R1", "R2"] {
        fs::copy(excerpt(name), workspace.path(&format!("two/{name}.mcap"))).unwrap();
    }
    workspace.write("two/clip.mp4", "");
    for options in [
        &["record", "two", "--out", "x.mcap"][..],
        &["record", "two", "--out", "y.mcap", "--frames", "2"],
        &["localize", "two", "--map", MAP, "--frames", "2"],
    ] {
        let said = workspace.must(options).stdout;
        assert!(said.contains("read as one recording, in this order: R1.mcap, R2.mcap"), "{said}");
        assert!(said.contains("note: two: left out: clip.mp4"), "{said}");
    }
}

#[test]
fn a_calibration_for_another_size_of_the_same_photo_is_converted() {
    let workspace = Workspace::new();
    save_png(&RgbImage::new(320, 240), &workspace.path("photo.png")).unwrap();
    workspace.write(
        "camera.toml",
        "model = \"pinhole\"\nsize_px = [640, 480]\nfocal_px = [525.0, 525.0]\ncenter_px = [320.0, 240.0]\n",
    );
    let locate =
        ["locate", "photo.png", "--map", MAP, "--camera", "camera.toml", "--pitch", "10", "--height", "0.5"];
    let said = workspace.must(&locate).stdout;
    assert!(said.contains("it is converted by the factor 0.5000"), "{said}");
}

#[test]
fn results_stand_beside_the_input() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    workspace.must(&["localize", &bag, "--map", MAP, "--frames", "60", "--bag-out", "out/results.mcap"]);
    let mut reader = BagReader::open(workspace.path("out/results.mcap"), BagTopics::default()).unwrap();
    let count = |topic: &str| {
        reader.available_topics().iter().find(|info| info.topic == topic).map(|info| info.num_messages)
    };
    assert_eq!(count("/visloc/reliability"), Some(60));
    assert_eq!(count("/diagnostics"), Some(60));
    // Poses are published from the moment on at which the robot is localized; a goal is in view until frame 7 and from frame 26 on.
    assert!(count("/visloc/pose").unwrap() > 25 && count("/visloc/path").unwrap() > 1);
    let mut num_frames = 0;
    while let Some(frame) = reader.next_item() {
        assert!(frame.unwrap().truth.is_some());
        num_frames += 1;
    }
    assert_eq!((num_frames, reader.status().skipped.len()), (60, 0));
}

#[test]
fn a_camera_in_a_map_of_slam_has_the_same_outputs_as_a_robot_on_a_drawn_map() {
    let workspace = Workspace::new();
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip");
    workspace.must(&["slam", clip, "--save", "desk.vmap"]);
    let see = ["localize", clip, "--map", "desk.vmap"];
    workspace.must(&[&see[..], &["--record", "run.mcap", "--trajectory", "camera.tum"]].concat());
    let recorded = workspace.read("camera.tum").lines().count();
    assert!(recorded > 40, "{recorded}");
    assert!(fs::metadata(workspace.path("run.mcap")).unwrap().len() > 100_000);
    let error = workspace.refused(&[&see[..], &["--bag-out", "results.mcap"]].concat());
    assert!(error.contains("robot") && !workspace.path("results.mcap").exists(), "{error}");
    // A recording of a camera has no robot in it.
    workspace.must(&["record", clip, "--out", "clip.mcap"]);
    let alone = workspace.must(&["localize", "clip.mcap", "--map", "desk.vmap", "--json", "alone.json"]);
    assert!(alone.stdout.contains("the poses are those of the camera"), "{}", alone.stdout);
    assert!(workspace.json("alone.json")["localized"].as_f64().unwrap() > 0.9);
    // A robot on a field finds nothing of a desk, and says so on all topics.
    let bag = excerpt_text("R1");
    let robot = ["localize", &bag, "--map", "desk.vmap", "--frames", "20", "--bag-out", "robot.mcap"];
    let said = workspace.must(&robot).stdout;
    assert!(said.contains("100 %  the place is not recognized"), "{said}");
    let reader = BagReader::open(workspace.path("robot.mcap"), BagTopics::default()).unwrap();
    let topics = reader.available_topics();
    let count = |topic: &str| topics.iter().find(|info| info.topic == topic).map(|info| info.num_messages);
    assert_eq!((count("/visloc/reliability"), count("/diagnostics")), (Some(20), Some(20)));
    assert_eq!(count("/visloc/pose").unwrap_or(0), 0);
}

#[test]
fn a_map_of_given_poses_is_merged_trimmed_and_written_for_nav2() {
    let workspace = Workspace::new();
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip");
    let poses = format!("{clip}/groundtruth.txt");
    let text =
        workspace.must(&["slam", clip, "--stride", "6", "--poses", &poses, "--save", "given.vmap"]).stdout;
    assert!(text.contains("10 images, 10 of them with a pose"), "{text}");
    workspace.must(&["localize", clip, "--map", "given.vmap", "--json", "run.json"]);
    let run = workspace.json("run.json");
    assert!(run["localized"].as_f64().unwrap() > 0.9, "{run}");
    assert!(run["error"]["median_m"].as_f64().unwrap() < 0.01, "{run}");
    workspace.write(
        "tele.toml",
        "model = \"pinhole\"\nsize_px = [320, 240]\nfocal_px = [787.5, 787.5]\ncenter_px = [160.0, 120.0]\n",
    );
    let tele = ["localize", clip, "--map", "given.vmap", "--camera", "tele.toml", "--frames", "3"];
    let said = workspace.visloc(&tele).stdout;
    assert!(said.contains("787.5 px") && said.contains("262.5 px"), "{said}");
    let error = workspace.refused(&["slam", clip, "--poses", "given.tum", "--save", "none.vmap"]);
    assert!(error.contains("given.tum"), "{error}");
    workspace.write("given.tum", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
    let error = workspace.refused(&["slam", clip, "--poses", "given.tum", "--save", "none.vmap"]);
    assert!(error.contains("at least 2 images") && !workspace.path("none.vmap").exists(), "{error}");

    workspace.must(&["slam", clip, "--save", "desk.vmap"]);
    let text = workspace.must(&["map", "merge", "desk.vmap", "given.vmap", "--out", "both.vmap"]).stdout;
    assert!(text.contains("show the same places"), "{text}");
    let text = workspace.must(&["map", "show", "both.vmap", "--plots", "both"]).stdout;
    assert!(text.contains("aligned to known places") && workspace.path("both/map.png").exists(), "{text}");
    workspace.must(&["map", "trim", "both.vmap", "--keyframes", "6", "--out", "both.vmap"]);
    assert!(workspace.path("both.vmap~").exists(), "what was there is kept");
    let text = workspace.must(&["map", "info", "both.vmap"]).stdout;
    assert!(text.contains("both.vmap: 6 keyframes"), "{text}");
    // What is damaged alike is told at once. The last pictures are cut off.
    let whole = fs::read(workspace.path("both.vmap")).unwrap();
    fs::write(workspace.path("cut.vmap"), &whole[..whole.len() / 2]).unwrap();
    let told = workspace.must(&["map", "info", "cut.vmap"]).stdout;
    assert!(told.contains("sections from picture") && told.matches("damaged").count() == 1, "{told}");

    workspace.must(&["map", "export", "given.vmap", "--floor", "floor"]);
    let picture = fs::read(workspace.path("floor/floor.pgm")).unwrap();
    assert!(picture.starts_with(b"P5\n") && workspace.read("floor/floor.yaml").contains("resolution: 0.05"));
    let cells = |value: u8| picture.iter().filter(|cell| **cell == value).count();
    assert!(cells(0) > 10 && cells(254) > 100, "{} occupied, {} free", cells(0), cells(254));
    // Our own occupancy grids are read by the same reader as everybody's.
    assert_eq!(workspace.visloc(&["map", "import", "floor/floor.yaml"]).code, 0);
    let error = workspace.refused(&["map", "export", "desk.vmap", "--floor", "none"]);
    assert!(error.contains("z up") && !workspace.path("none").exists(), "{error}");
}

#[test]
fn slam_reads_bags_and_simulated_robots() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let text = workspace.must(&["slam", &bag, "--start", "1s", "--until", "40", "--stride", "2"]).stdout;
    assert!(text.contains("R1-excerpt.mcap: 15 frames"), "{text}");
    let text = workspace.must(&["slam", "sim:office", "--until", "5", "--no-publish-ros"]).stdout;
    assert!(text.contains("sim:office: 5 frames"), "{text}");
}

#[test]
fn a_part_is_taken_of_any_source() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let stamps = |name: &str| -> Vec<f64> {
        let text = workspace.read(name);
        let first = |line: &str| line.split([' ', ',']).next().unwrap().parse().unwrap();
        data_lines(&text).iter().map(|line| first(line)).collect()
    };
    let part = ["--from", "2s", "--until", "3s"];
    let all = ["localize", &bag, "--map", MAP, "--trajectory", "all.tum"];
    workspace.must(&all);
    let whole = stamps("all.tum");
    let wanted: Vec<f64> = whole.iter().copied().filter(|at| (2.0..3.0).contains(&(at - whole[0]))).collect();
    assert!(wanted.len() > 5);
    workspace.must(&[&["localize", &bag, "--map", MAP, "--trajectory", "part.tum"], &part[..]].concat());
    assert_eq!(stamps("part.tum"), wanted);
    workspace.must(&[&["record", &bag, "--out", "part.mcap"], &part[..]].concat());
    workspace.must(&["localize", "part.mcap", "--map", MAP, "--trajectory", "recorded.tum"]);
    assert_eq!(stamps("recorded.tum"), wanted);
    // A part of a bag has all topics of the whole one.
    let topics = |path: &Path| -> BTreeSet<String> {
        let mut messages = BagMessages::open(path).unwrap();
        let mut topics = BTreeSet::new();
        while let Some(message) = messages.next_message() {
            topics.insert(message.unwrap().channel.topic.clone());
        }
        topics
    };
    assert_eq!(topics(&workspace.path("part.mcap")), topics(Path::new(&bag)));
    workspace.must(&[&["extract", &bag, "--out", "images"], &part[..]].concat());
    assert_eq!(stamps("images/rgb.txt"), wanted);
    workspace.must(&["localize", "sim:still", "--from", "5", "--frames", "4", "--trajectory", "sim.tum"]);
    assert_eq!(stamps("sim.tum").len(), 4);
    let error = workspace.refused(&["localize", &bag, "--map", MAP, "--from", "900s"]);
    assert!(error.contains("in the range that was asked for: the source has 90 images"), "{error}");
    for (from, until) in [("2s", "15"), ("15", "1s")] {
        for command in [&["localize", &bag, "--map", MAP][..], &["record", &bag, "--out", "none.mcap"]] {
            let error = workspace.refused(&[command, &["--from", from, "--until", until]].concat());
            assert!(error.contains("range that was asked for: it ends before it begins"), "{error}");
        }
    }
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip");
    workspace.must(&["slam", clip, "--from", "5", "--stride", "2", "--frames", "10", "--json", "slam.json"]);
    assert_eq!(workspace.json("slam.json")["frames"], 10);
}

#[test]
fn a_number_of_frames_only_ever_shortens_a_simulation() {
    let workspace = Workspace::new();
    workspace
        .write("short.toml", "duration_secs = 0.5\nframes_per_sec = 10.0\n[[motion]]\nstand.secs = 1.0\n");
    for (asked, expected) in [("3", 3), ("5", 5), ("9", 5), ("4000000000", 5)] {
        let run = ["--frames", asked, "--overwrite"];
        workspace
            .must(&[&["simulate", "short.toml", "--out", "s.mcap", "--json", "s.json"], &run[..]].concat());
        assert_eq!(workspace.json("s.json")["frames"], expected, "simulate --frames {asked}");
        let localize = ["localize", "sim:short.toml", "--json", "l.json"];
        workspace.must(&[&localize[..], &run[..]].concat());
        assert_eq!(workspace.json("l.json")["frames"], expected, "localize --frames {asked}");
    }
}

#[test]
fn a_photo_is_located_in_a_map_of_slam() {
    let workspace = Workspace::new();
    let clip = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip");
    let text = |path: &Path| path.display().to_string();
    workspace.must(&["slam", &text(&clip), "--save", "desk.vmap", "--trajectory", "way.tum"]);
    let list = fs::read_to_string(clip.join("rgb.txt")).unwrap();
    let (at, photo) = data_lines(&list)[40].split_once(' ').unwrap();
    let (photo, camera) = (text(&clip.join(photo)), text(&clip.join("camera.yaml")));
    let base = ["locate", &photo, "--map", "desk.vmap", "--camera", &camera];
    workspace.must(&[&base[..], &["--json", "p.json", "--out", "out"]].concat());
    let place = &workspace.json("p.json")["poses"][0];
    assert!(place["probability"].as_f64().unwrap() > 0.9, "{place}");
    let way = workspace.read("way.tum");
    let line = data_lines(&way).into_iter().find(|line| line.starts_with(at)).unwrap();
    let pose: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
    for (axis, expected) in ["x", "y", "z"].iter().zip(&pose[1..4]) {
        assert!((place[*axis].as_f64().unwrap() - expected).abs() < 0.01, "{place}, expected {line}");
    }
    assert!(workspace.path("out/place-1.png").exists());
    // A camera of three times the size sees nothing else.
    let small = read_image(Path::new(&photo)).unwrap();
    let mut large = RgbImage::new(3 * small.width(), 3 * small.height());
    for y in 0..large.height() {
        for x in 0..large.width() {
            large.set(x, y, small.get(x / 3, y / 3));
        }
    }
    save_png(&large, &workspace.path("large.png")).unwrap();
    let large = ["locate", "large.png", "--map", "desk.vmap", "--camera", &camera, "--json", "l.json"];
    workspace.must(&[&large[..], &["--out", "large"]].concat());
    let again = &workspace.json("l.json")["poses"][0];
    assert!((again["x"].as_f64().unwrap() - pose[1]).abs() < 0.02, "{again}, expected {line}");
    // One of a tenth of it sees no corners of the map.
    let tiny = RgbImage::new(small.width() / 10, small.height() / 10);
    save_png(&tiny, &workspace.path("tiny.png")).unwrap();
    let tiny = ["locate", "tiny.png", "--map", "desk.vmap", "--camera", &camera, "--json", "t.json"];
    workspace.must(&tiny);
    assert_eq!(workspace.json("t.json")["diagnosis"][0]["code"], "few-pixels");
    let error = workspace.refused(&[&base[..], &["--height", "1"]].concat());
    assert!(error.contains("--height: it makes no difference in a map of SLAM"), "{error}");
    // Another room.
    save_png(&RgbImage::new(320, 240), &workspace.path("dark.png")).unwrap();
    let dark = ["locate", "dark.png", "--map", "desk.vmap", "--camera", &camera, "--out", "out"];
    let said = workspace.must(&dark).stdout;
    assert!(said.contains("100 %  at a place that is not among these") && said.contains("->"), "{said}");
    assert!(!workspace.path("out/place-1.png").exists(), "of the photo before");
    assert!(workspace.path("out/not-recognized.png").exists());
}
