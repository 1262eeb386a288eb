//! Datasets of every layout, made here from a few small images.

#![allow(clippy::unwrap_used)] // a test may stop

use std::{
    fs,
    path::{Path, PathBuf},
};

use nalgebra::Vector3;
use visloc_core::{ImageSource, RgbImage, Source};
use visloc_io::{
    image_codec::{save_jpeg, save_png},
    sequence::{Bound, Sequence, SequenceOptions, SequenceRange, open_sequence},
};

/// A folder that is filled by hand.
struct Dataset(tempfile::TempDir, String);

const YAML: &str = "width: 64\nheight: 48\nfx: 60\nfy: 60\ncx: 31.5\ncy: 23.5\n";

impl Dataset {
    fn named(name: &str) -> Self {
        let dataset = Self(tempfile::tempdir().unwrap(), name.to_owned());
        fs::create_dir_all(dataset.path("")).unwrap();
        dataset
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(&self.1).join(name)
    }

    fn text(&self, name: &str, text: &str) -> &Self {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), text).unwrap();
        self
    }

    fn image(&self, name: &str, (width, height): (u32, u32)) -> &Self {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut image = RgbImage::new(width, height);
        image.data_mut().iter_mut().enumerate().for_each(|(i, v)| *v = (i % 251) as u8);
        match path.extension().unwrap() == "png" {
            true => save_png(&image, &path).unwrap(),
            false => save_jpeg(&image, 90, &path).unwrap(),
        }
        self
    }

    fn open(&self, options: &SequenceOptions) -> Result<Sequence, String> {
        open_sequence(&self.path(""), options).map_err(|error| error.to_string())
    }

    fn opened(&self) -> Sequence {
        self.open(&SequenceOptions::default()).unwrap()
    }
}

/// Stamps of the images that can be read, seconds.
fn stamps(sequence: &mut Sequence) -> Vec<f64> {
    let mut stamps = Vec::new();
    while let Some(image) = sequence.images.next_item() {
        // To the microsecond: seconds since 1970 have no more digits.
        stamps.push((image.unwrap().at.secs() * 1e6).round() / 1e6);
    }
    stamps
}

fn positions(sequence: &Sequence) -> Vec<Vector3<f64>> {
    let truth = sequence.truth.as_ref().unwrap();
    truth.poses().iter().map(|pose| *pose.world_from_camera.translation()).collect()
}

#[test]
fn tum_with_its_own_calibration_and_by_name() {
    let list = "# stamps\n10.5 rgb/a.png\n10.6 rgb/b.jpg\n";
    let dataset = Dataset::named("desk");
    dataset.image("rgb/a.png", (64, 48)).image("rgb/b.jpg", (64, 48)).text("rgb.txt", list);
    assert!(dataset.open(&SequenceOptions::default()).unwrap_err().contains("--camera"));
    dataset.text("camera.yaml", YAML).text("groundtruth.txt", "10.5 1 2 3 0 0 0 1\n");
    let mut sequence = dataset.opened();
    assert_eq!((sequence.layout, sequence.warnings.len()), ("TUM RGB-D", 0));
    assert_eq!(positions(&sequence), [Vector3::new(1.0, 2.0, 3.0)]);
    assert_eq!(stamps(&mut sequence), [10.5, 10.6]);

    let benchmark = Dataset::named("rgbd_dataset_freiburg2_desk");
    benchmark.image("rgb/a.png", (640, 480)).text("rgb.txt", "10.5 rgb/a.png\n");
    assert_eq!(benchmark.opened().images.camera().focal_px(), (520.9, 521.0));
}

#[test]
fn icl_nuim_is_mirrored_into_a_right_handed_world() {
    let dataset = Dataset::named("living_room_traj0");
    for name in ["0.png", "2.png", "10.png"] {
        dataset.image(&format!("rgb/{name}"), (640, 480));
    }
    // A quarter turn around x.
    dataset.text("livingRoom0.gt.freiburg", "0 1 2 3 0.70710678 0 0 0.70710678\n3 1 2 4 0 0 0 1\n");
    let mut sequence = dataset.opened();
    assert_eq!((sequence.layout, sequence.images.camera().focal_px()), ("ICL-NUIM", (481.2, 480.0)));
    assert_eq!(positions(&sequence)[0], Vector3::new(1.0, -2.0, 3.0));
    let pose = sequence.truth.as_ref().unwrap().poses()[0].world_from_camera;
    // The camera looked along -y of the mirrored world, so it looks along +y of ours.
    assert!((pose.rotate(&Vector3::z()) - Vector3::y()).norm() < 1e-6);
    assert!((pose.rotation().determinant() - 1.0).abs() < 1e-9);
    let found = stamps(&mut sequence);
    assert!(found.iter().zip([0.0, 2.0 / 30.0, 10.0 / 30.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
}

const SENSOR: &str = "T_BS:\n  data: [0, -1, 0, 0.5,\n  1, 0, 0, 0,\n  0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 20\n\
                      resolution: [64, 48]\nintrinsics: [60, 60, 31.5, 23.5]\n";

#[test]
fn euroc_gives_the_truth_of_the_camera() {
    let dataset = Dataset::named("MH_01_easy");
    let list = "#timestamp [ns],filename\n1403636579763555584,a.png\n1403636579813555456,b.png\n";
    dataset.text("mav0/cam0/sensor.yaml", SENSOR).text("mav0/cam0/data.csv", list);
    dataset.image("mav0/cam0/data/a.png", (64, 48)).image("mav0/cam0/data/b.png", (64, 48));
    let truth = "#timestamp,...\n1403636579763555584,1,2,3,1,0,0,0,0,0,0\n";
    dataset.text("mav0/state_groundtruth_estimate0/data.csv", truth);
    let mut sequence = dataset.opened();
    assert_eq!(sequence.layout, "EuRoC (ASL)");
    assert_eq!(positions(&sequence), [Vector3::new(1.5, 2.0, 3.0)]);
    let pose = sequence.truth.as_ref().unwrap().poses()[0].world_from_camera;
    assert_eq!(pose.rotate(&Vector3::x()), Vector3::y());
    assert_eq!(sequence.images.files()[0].at.nanos(), 1_403_636_579_763_555_584);
    assert_eq!(stamps(&mut sequence).len(), 2);
}

#[test]
fn zurich_has_a_place_for_some_images() {
    let dataset = Dataset::named("AGZ");
    dataset.image("MAV Images/00001.jpg", (192, 108)).image("MAV Images/00031.jpg", (192, 108));
    let truth = "imgid, x_gt, y_gt, z_gt, omega, phi, kappa, x_gps\n1,465666.5,5247973.0,469.0,90,0,0,0\n\
                 31,465668.5,5247972.0,470.0,90,0,0,0\n";
    dataset.text("Log Files/GroundTruthAGL.csv", truth);
    let sequence = dataset.opened();
    assert_eq!(sequence.layout, "Zurich urban MAV");
    assert_eq!(positions(&sequence)[1], Vector3::new(2.0, -1.0, 1.0));
    assert_eq!(sequence.images.files()[1].at.secs_since(sequence.images.files()[0].at), 1.0);
    // Smaller copies of the images: the calibration follows, with a warning.
    assert!((sequence.images.camera().focal_px().0 - 89.339).abs() < 1e-3);
    assert!(sequence.warnings[0].contains("1920 x 1080 px, these have 192 x 108"), "{:?}", sequence.warnings);
}

#[test]
fn kitti_finds_times_and_poses() {
    let dataset = Dataset::named("dataset/sequences/06");
    let calib = "P0: 60 0 31.5 0 0 60 23.5 0 0 0 1 0\nP1: 60 0 31.5 -30 0 60 23.5 0 0 0 1 0\n";
    dataset.text("calib.txt", calib).text("times.txt", "0.0e+00\n1.037e-01\n");
    dataset.image("image_0/000000.png", (64, 48)).image("image_0/000001.png", (64, 48));
    dataset.text("../../poses/06.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1.2\n");
    let mut sequence = dataset.opened();
    assert_eq!((sequence.layout, sequence.images.camera().center_px()), ("KITTI odometry", (31.5, 23.5)));
    assert_eq!(positions(&sequence)[1], Vector3::new(0.0, 0.0, 1.2));
    assert_eq!(sequence.truth.as_ref().unwrap().poses()[1].at.nanos(), 103_700_000);
    assert_eq!(stamps(&mut sequence), [0.0, 0.1037]);
}

#[test]
fn plain_folders_take_times_from_names_or_from_the_rate() {
    let dataset = Dataset::named("mine");
    dataset.text("camera.yaml", &format!("{YAML}fps: 10\n"));
    for name in ["left2.png", "left10.png", "left1.jpg"] {
        dataset.image(name, (64, 48));
    }
    let mut sequence = dataset.opened();
    let first = sequence.images.files()[0].path.file_name().unwrap().to_owned();
    assert_eq!((sequence.layout, first.to_str().unwrap()), ("folder of images", "left1.jpg"));
    assert_eq!(stamps(&mut sequence), [0.0, 0.1, 0.2]);
    let stamped = Dataset::named("stamped");
    stamped.text("camera.yaml", YAML);
    stamped.image("images/100.25.png", (64, 48)).image("images/99.75.png", (64, 48));
    assert_eq!(stamps(&mut stamped.opened()), [99.75, 100.25]);
}

/// Five images, 10 a second.
fn five() -> Dataset {
    let dataset = Dataset::named("five");
    let lines = (0..5).map(|i| format!("{}.{} {i}.png\n", 7, i)).collect::<String>();
    dataset.text("camera.yaml", YAML).text("rgb.txt", &lines);
    for i in 0..5 {
        dataset.image(&format!("{i}.png"), (64, 48));
    }
    dataset
}

#[test]
fn ranges_strides_and_scales() {
    let range = SequenceRange {
        start: Bound::Secs(0.1),
        end: Some(Bound::Frame(4)),
        stride: 2,
        ..SequenceRange::default()
    };
    let options = SequenceOptions { range, scale: Some(0.5), ..SequenceOptions::default() };
    let dataset = five();
    let mut sequence = dataset.open(&options).unwrap();
    assert_eq!(sequence.images.camera().size_px(), (32, 24));
    assert_eq!(sequence.images.camera().center_px(), (15.5, 11.5));
    let image = sequence.images.next_item().unwrap().unwrap().image;
    assert_eq!((image.width(), image.height()), (32, 24));
    assert_eq!(stamps(&mut sequence), [7.3]);
    // Large ones are shrunk by a whole number where no scale is asked for.
    for (scale, most_side_px, width) in [
        (None, Some(64), 64),
        (None, Some(63), 32),
        (None, Some(30), 21),
        (None, Some(20), 64),
        (Some(1.0), Some(30), 64),
    ] {
        let options = SequenceOptions { scale, most_side_px, ..SequenceOptions::default() };
        let mut sequence = dataset.open(&options).unwrap();
        assert_eq!(sequence.images.camera().size_px().0, width);
        assert_eq!(sequence.images.next_item().unwrap().unwrap().image.width(), width as usize);
        assert_eq!(sequence.warnings.iter().any(|warning| warning.contains("--scale 1")), width < 64);
    }
    let range = SequenceRange { start: Bound::Frame(9), ..SequenceRange::default() };
    let options = SequenceOptions { range, ..SequenceOptions::default() };
    assert!(five().open(&options).unwrap_err().contains("5 images, found none"));
    let options = SequenceOptions { scale: Some(f64::NAN), ..SequenceOptions::default() };
    assert!(five().open(&options).unwrap_err().contains("scale"));
}

#[test]
fn bad_images_and_lines_are_left_out_and_named() {
    let dataset = five();
    let list =
        "7.0 0.png\n7.1 1.png\n7.1 2.png\n6.0 2.png\nsoon 3.png\n7.3\n7.4 4.png\n7.5 gone.png\n9.9 3.png\n";
    dataset.text("rgb.txt", list).image("1.png", (32, 48));
    let whole = fs::read(dataset.path("4.png")).unwrap();
    fs::write(dataset.path("4.png"), &whole[..whole.len() / 2]).unwrap();
    let mut sequence = dataset.opened();
    assert!(sequence.warnings[0].contains("1 of 7 images are listed after later ones"));
    let said = &sequence.warnings[1];
    assert!(said.contains("a gap in the images: 2.40 s instead of 0.300"), "{said}");
    assert_eq!(stamps(&mut sequence), [6.0, 7.0, 9.9], "the order is that of the times");
    let skipped: Vec<String> =
        sequence.images.status().skipped.iter().map(|s| format!("{}: {}", s.origin, s.reason)).collect();
    for (skipped, expected) in skipped.iter().zip([
        "rgb.txt, line 5: expected a finite number, found 'soon'",
        "rgb.txt, line 6: expected 'SECONDS FILE', found '7.3'",
        "rgb.txt, line 3: expected one image at a time, found 7.1",
        "1.png: expected 64 x 48 px, found 32 x 48",
        "4.png: expected a JPEG or PNG",
        "gone.png: ",
    ]) {
        assert!(skipped.contains(expected), "{skipped} (expected {expected})");
    }
    assert_eq!(skipped.len(), 6);
}

#[test]
fn unlikely_calibrations_are_warned_about() {
    for (from, to, expected) in [
        ("cx: 31.5", "cx: 90", "principal point (90.0, 23.5) is outside"),
        ("fy: 60", "fy: 200", "fx is 60.0 px and fy 200.0"),
        ("fx: 60\nfy: 60", "fx: 900\nfy: 900", "sees 4 degrees across"),
        ("width: 64\nheight: 48", "width: 640\nheight: 480", "converted by the factor 0.1"),
    ] {
        let dataset = five();
        dataset.text("camera.yaml", &YAML.replace(from, to));
        let warnings = dataset.opened().warnings.join("; ");
        assert!(warnings.contains(expected), "{warnings} (expected {expected})");
    }
    let dataset = five();
    let error = dataset.text("camera.yaml", &YAML.replace("fx: 60", "fx: -60"));
    let error = error.open(&SequenceOptions::default()).unwrap_err();
    assert!(error.contains("camera.yaml") && error.contains("positive focal lengths"), "{error}");
    let cropped = dataset.text("camera.yaml", &YAML.replace("height: 48", "height: 60"));
    let error = cropped.open(&SequenceOptions::default()).unwrap_err();
    assert!(error.contains("64 x 60 px, these have 64 x 48: cropped"), "{error}");
}

#[test]
fn what_is_no_dataset_says_what_is_expected() {
    let empty = Dataset::named("empty");
    let error = empty.open(&SequenceOptions::default()).unwrap_err();
    for expected in ["rgb.txt", "mav0/cam0", "image_0", "KITTI", "found none of them"] {
        assert!(error.contains(expected), "{error}");
    }
    assert!(open_sequence(Path::new("/nowhere"), &SequenceOptions::default()).is_err());
    let broken = five();
    for i in 0..5 {
        broken.text(&format!("{i}.png"), "no image");
    }
    let error = broken.open(&SequenceOptions::default()).unwrap_err();
    assert!(error.contains("none of 5 that can be read"), "{error}");
    let unread = five();
    unread.text("groundtruth.txt", "7.0 1 2 3\n");
    let sequence = unread.opened();
    assert!(sequence.truth.is_none() && sequence.warnings[0].contains("groundtruth.txt: line 1"));
}
