//! Every option with every kind of source, for every purpose: it changes the result, or the source refuses it with a
//! sentence that names it. A new kind needs an example here, a new option a value to try.
#![cfg(unix)]
#![allow(clippy::unwrap_used)]

mod programs;

use std::{
    collections::BTreeSet,
    fs,
    path::PathBuf,
    time::{SystemTime, UNIX_EPOCH},
};

use programs::write_program;
use tempfile::TempDir;
use visloc_core::{
    Frame, Host, RgbImage, SourceFrame, Timestamp, Truth,
    geom::{Camera, Mount, PlanarPose},
};
use visloc_io::{
    bag::{BagTopics, BagWriter, ImageQos},
    image_codec::save_png,
    sequence::{Bound, SequenceRange},
    sources::{
        KINDS, Purpose, SourceAddress, SourceOption, SourceOptions, open_frames, open_images, open_pictures,
    },
};

const SIZE_PX: (u32, u32) = (64, 48);
const NUM_IMAGES: u8 = 3;
const SCENARIO: &str = "map = \"robocup-spl-2010\"\nduration_secs = 0.1\n[camera]\nsize_px = [64, 48]\n\
                        focal_px = [75.0, 75.0]\ncenter_px = [31.5, 23.5]\n";
const ROBOT: &str = "<robot name=\"r\"><joint name=\"neck\" type=\"fixed\"><parent link=\"base_footprint\"/><child link=\"eye\"/>\
                     <origin xyz=\"0 0 0.6\" rpy=\"-1.6 0 -1.6\"/></joint></robot>";

/// Files for one example of every kind, and programs in place of ffmpeg.
struct Place {
    folder: TempDir,
}

/// A source, and options with which it opens.
struct Example {
    text: String,
    base: SourceOptions,
}

impl Place {
    fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        for (name, focal) in [("camera.toml", 60.0), ("other.toml", 80.0)] {
            place.write(name, &calibration(focal));
        }
        place.program("ffmpeg", 20, "exit 0");
        place.program("other", 40, "exit 0");
        place.program("silent", 20, "exec sleep 20");
        place.write("clip.mp4", "");
        place.write("small.toml", SCENARIO);
        place.write("robot.urdf", ROBOT);
        let names: Vec<String> = (0..NUM_IMAGES).map(|i| format!("{i}.png")).collect();
        for (i, name) in (0..).zip(&names) {
            for folder in ["photos", "tum/rgb", "kitti/image_0"] {
                place.image(&format!("{folder}/{name}"), 10 * i);
            }
        }
        let list = |(i, name): (usize, &String)| format!("1{i}.5 rgb/{name}\n");
        place.write("tum/rgb.txt", &names.iter().enumerate().map(list).collect::<String>());
        place.write("kitti/calib.txt", "P0: 60 0 31.5 0 0 60 23.5 0 0 0 1 0\n");
        place.write("kitti/times.txt", "0.0\n0.1\n0.2\n");
        place.bag("bag/a.mcap", &BagTopics::default(), 0);
        place.bag("bag/b.mcap", &other_topics(), 100);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), text).unwrap();
    }

    fn image(&self, name: &str, gray: u8) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        save_png(&plain(gray), &self.path(name)).unwrap();
    }

    /// Writes images whose gray is told by whether `--fps 7` has reached the program.
    fn program(&self, name: &str, gray: u8, end: &str) {
        let bytes = usize::try_from(SIZE_PX.0 * SIZE_PX.1).unwrap();
        let script = format!(
            "#!/bin/sh\n[ \"$1\" = -version ] && echo 'ffmpeg version 5.1.9' && exit 0\n\
             gray='\\{gray:03o}'\ncase \"$*\" in *'-framerate 7'*) gray='\\177';; esac\ni=0\n\
             while [ $i -lt {NUM_IMAGES} ]; do\necho \"[x] [info] n: $i pts_time:0.$((i + 1))0 fmt:gray\" >&2\n\
             printf 'P5\\n{} {}\\n255\\n'\nhead -c {bytes} /dev/zero | tr '\\000' \"$gray\"\ni=$((i + 1))\ndone\n{end}\n",
            SIZE_PX.0, SIZE_PX.1
        );
        write_program(&self.path(name), &script);
    }

    fn bag(&self, name: &str, topics: &BagTopics, gray: u8) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        let mut writer = BagWriter::create(self.path(name), topics.clone()).unwrap();
        for i in 0..NUM_IMAGES {
            let moved = PlanarPose::new(f64::from(i), f64::from(gray), 0.0);
            let frame = Frame {
                at: Timestamp::from_secs(100.0 + 0.1 * f64::from(i)),
                image: plain(gray + 10 * i),
                camera_index: 0,
                camera: Camera::pinhole(SIZE_PX, (70.0 + f64::from(gray), 70.0), (31.5, 23.5)).unwrap(),
                robot_from_camera: Mount { height_m: 0.4, ..Mount::default() }.robot_from_camera(),
                odometry: Some(moved),
                ground_contact: None,
            };
            let truth = Some(Truth { world_from_robot: moved, height_m: 0.0 });
            writer.write(&SourceFrame { frame, truth }).unwrap();
        }
        writer.finish().unwrap();
    }

    /// Examples of a kind of source.
    fn examples(&self, kind: &str) -> Vec<Example> {
        let path = |name: &str| self.path(name).display().to_string();
        let example = |text: String, base: SourceOptions| Example { text, base };
        let plain = SourceOptions::default();
        let calibrated = SourceOptions { camera: Some(self.path("camera.toml")), ..plain.clone() };
        let decoded = SourceOptions { ffmpeg: Some(self.path("ffmpeg")), ..calibrated.clone() };
        let three = SequenceRange { end: Some(Bound::Frame(3)), ..SequenceRange::default() };
        match kind {
            "simulator" => vec![
                example(format!("sim:{}", path("small.toml")), plain.clone()),
                example("sim:room".into(), SourceOptions { range: three, ..plain }),
            ],
            "ROS bag" => vec![example(path("bag"), plain)],
            "images" => vec![
                example(path("photos"), calibrated.clone()),
                example(path("tum"), calibrated.clone()),
                example(path("kitti"), calibrated),
            ],
            "video" => vec![example(path("clip.mp4"), decoded)],
            "camera" => vec![example("v4l2:/dev/null".into(), decoded)],
            "loop" => vec![example(format!("loop:{}", path("photos")), decoded)],
            "ROS 2 topics" => vec![example("ros2:".into(), plain)],
            other => panic!("a new kind of source, '{other}', needs an example"),
        }
    }

    /// The options with another value of one of them; several where it has several parts.
    fn trials(&self, option: SourceOption, base: &SourceOptions, is_live: bool) -> Vec<SourceOptions> {
        let mut next = base.clone();
        let other = other_topics();
        let mount = base.mount.unwrap_or_default();
        match option {
            SourceOption::Camera => next.camera = Some(self.path("other.toml")),
            SourceOption::Mount => {
                let parts = [
                    Mount { height_m: 0.7, ..mount },
                    Mount { height_m: 0.5, forward_m: 0.1, ..mount },
                    Mount { height_m: 0.5, tilt_rad: 0.1, ..mount },
                    Mount { height_m: 0.5, pan_rad: 0.1, ..mount },
                    Mount { height_m: 0.5, roll_rad: 0.1, ..mount },
                ];
                let with = |mount| SourceOptions { mount: Some(mount), ..base.clone() };
                return parts.into_iter().map(with).collect();
            }
            // It tells where frames are of which tf says nothing.
            SourceOption::Urdf => {
                next.urdf = Some(self.path("robot.urdf"));
                next.topics.camera_frame = Some("eye".into());
            }
            SourceOption::Topics => next.topics.all = Some(other),
            SourceOption::ImageTopic => next.topics.image = Some(other.image),
            SourceOption::CameraInfoTopic => next.topics.camera_info = Some(other.camera_info),
            SourceOption::OdometryTopic => next.topics.odometry = Some(other.odometry),
            SourceOption::TruthTopic => next.topics.ground_truth = Some(other.ground_truth),
            SourceOption::BaseFrame => next.topics.base_frame = Some(other.base_frame),
            SourceOption::CameraFrame => next.topics.camera_frame = other.camera_frame,
            // Which images of a live source come is a matter of speed; none come from behind the end.
            SourceOption::Start => next.range.start = Bound::Frame(if is_live { 1000 } else { 1 }),
            SourceOption::End => {
                next.range.end = Some(if is_live { Bound::Secs(0.0) } else { Bound::Frame(2) });
            }
            SourceOption::Stride => next.range.stride = 2,
            SourceOption::Frames => next.range.most = Some(usize::from(!is_live)),
            SourceOption::Scale => next.scale = Some(0.5),
            SourceOption::Fps => next.rate_hz = Some(7.0),
            SourceOption::Seed => next.seed = Some(2),
            SourceOption::Threads => next.num_threads = Some(2),
            SourceOption::Patience => next.patience_secs = Some(0.2),
            SourceOption::ImageQos => next.image_qos = Some(ImageQos::Reliable),
            SourceOption::Ffmpeg => next.ffmpeg = Some(self.path("other")),
            SourceOption::RosDomain => next.domain_id = Some(99),
        }
        vec![next]
    }
}

fn calibration(focal: f64) -> String {
    format!(
        "model = \"pinhole\"\nsize_px = [{}, {}]\nfocal_px = [{focal:.1}, {focal:.1}]\ncenter_px = [31.5, 23.5]\n",
        SIZE_PX.0, SIZE_PX.1
    )
}

fn plain(gray: u8) -> RgbImage {
    let mut image = RgbImage::new(SIZE_PX.0, SIZE_PX.1);
    image.data_mut().fill(gray);
    image
}

/// Other names for everything but tf.
fn other_topics() -> BagTopics {
    BagTopics {
        image: "/other/image".into(),
        camera_info: "/other/camera_info".into(),
        odometry: "/other/odom".into(),
        ground_truth: "/other/truth".into(),
        base_frame: "other_base".into(),
        camera_frame: Some("other_camera".into()),
        ..BagTopics::default()
    }
}

#[allow(clippy::disallowed_methods)]
fn now() -> Timestamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).unwrap())
}

/// All that a source delivers, as text: of a live one without times and repetitions, which depend on the speed.
fn everything(
    text: &str,
    options: &SourceOptions,
    purpose: Purpose,
    is_live: bool,
) -> Result<BTreeSet<String>, String> {
    let host = Host::new(now, |_| {});
    let told = |error: &dyn std::fmt::Display| error.to_string();
    let mut all = BTreeSet::new();
    let mut add = |number: usize, at: Timestamp, what: String| {
        all.insert(if is_live { what } else { format!("{number} {at} {what}") });
    };
    let ended = |error: &dyn std::fmt::Display| format!("ended with {error}");
    let size = |image: &RgbImage| (image.width(), image.height(), sum(image.data()));
    match purpose {
        Purpose::Frames => {
            let mut frames = open_frames(text, options, &host).map_err(|error| told(&error))?.frames;
            let mut number = 0;
            while let Some(next) = frames.next_item() {
                match next {
                    Ok(SourceFrame { frame: f, truth }) => {
                        let rest = (f.camera, f.robot_from_camera, f.odometry, truth);
                        add(number, f.at, format!("{:?} {rest:?}", size(&f.image)));
                    }
                    Err(error) => add(number, Timestamp::default(), ended(&error)),
                }
                number += 1;
            }
        }
        Purpose::Images => {
            let mut images = open_images(text, options, &host).map_err(|error| told(&error))?.images;
            let camera = *images.camera();
            let mut number = 0;
            while let Some(next) = images.next_item() {
                match next {
                    Ok(frame) => {
                        let (image, at) = (&frame.image, frame.at);
                        let picture = (image.width(), image.height(), sum(image.data()));
                        let what = (picture, camera, frame.odom_from_camera, frame.truth);
                        add(number, at, format!("{what:?}"));
                    }
                    Err(error) => add(number, Timestamp::default(), ended(&error)),
                }
                number += 1;
            }
        }
        Purpose::Pictures => {
            let open = open_pictures(text, options, &host).map_err(|error| told(&error))?;
            let (mut pictures, calibration) = (open.pictures, open.calibration);
            let mut number = 0;
            while let Some(next) = pictures.next_item() {
                match next {
                    Ok(picture) => {
                        let what = (size(&picture.image), calibration.as_ref().map(|known| &known.0));
                        add(number, picture.at, format!("{what:?}"));
                    }
                    Err(error) => add(number, Timestamp::default(), ended(&error)),
                }
                number += 1;
            }
        }
    }
    Ok(all)
}

/// A number that any other image hardly has.
fn sum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(7, |sum, byte| sum.wrapping_mul(31).wrapping_add(u64::from(*byte)))
}

/// Tries one option with one source.
fn try_option(
    place: &Place,
    example: &Example,
    option: SourceOption,
    purpose: Purpose,
    without: &Result<BTreeSet<String>, String>,
) {
    let Example { text, base } = example;
    let address = SourceAddress::parse(text).unwrap();
    let is_live = address.kind().is_live;
    let is_honored = address.kind().honors(purpose, address.rest()).contains(&option);
    let context = format!("{} with {text} for {purpose:?}", option.flag());
    for trial in place.trials(option, base, is_live) {
        if option == SourceOption::Patience && is_honored {
            // It ends long before the program does.
            let silent = SourceOptions { ffmpeg: Some(place.path("silent")), ..trial };
            assert!(everything(text, &silent, purpose, is_live).is_ok(), "{context}");
            continue;
        }
        let with = everything(text, &trial, purpose, is_live);
        match &with {
            Err(error) if error.starts_with(&format!("{}: ", option.flag())) => {
                assert!(error.contains("leave"), "{context}: {error}");
                // The layout of a dataset is known only when it has been looked at.
                assert!(!is_honored || option == SourceOption::Fps, "{context}: honored, yet {error}");
            }
            _ if !is_honored => panic!("{context}: neither refused nor honored, {with:?}"),
            // Speed, and which images of a live source come, are not part of the result.
            _ if option == SourceOption::Threads => assert_eq!(with, *without, "{context}"),
            _ if option == SourceOption::Urdf => {
                let is_used = with.as_ref().is_ok_and(|all| !all.iter().any(|one| one.contains("ended")));
                assert!(is_used, "{context}: {with:?}");
            }
            _ if is_live && option == SourceOption::Stride => {}
            // This source cannot serve the purpose at all.
            Err(error) if without.as_ref() == Err(error) => {}
            _ => assert_ne!(with, *without, "{context}: accepted and ignored"),
        }
    }
}

#[test]
fn every_option_is_honored_or_refused_by_every_kind_of_source() {
    let place = Place::new();
    for kind in &KINDS {
        for example in place.examples(kind.name) {
            for purpose in Purpose::ALL {
                let base = base_for(purpose, &example);
                let example = Example { text: example.text.clone(), base };
                let is_live_topic = kind.schemes == ["ros2"];
                let without = match is_live_topic {
                    true => Err("not opened".into()),
                    false => everything(&example.text, &example.base, purpose, kind.is_live),
                };
                for option in SourceOption::ALL {
                    // Live topics need a network and somebody who publishes: here only what they refuse is tried.
                    let address = SourceAddress::parse(&example.text).unwrap();
                    let is_honored = kind.honors(purpose, address.rest()).contains(&option);
                    if !is_live_topic || !is_honored {
                        try_option(&place, &example, option, purpose, &without);
                    }
                }
            }
        }
    }
}

/// Frames of sources without a robot need a mount; a range is for what honors one.
fn base_for(purpose: Purpose, example: &Example) -> SourceOptions {
    let mut base = example.base.clone();
    let address = SourceAddress::parse(&example.text).unwrap();
    let honored = address.kind().honors(purpose, address.rest());
    if honored.contains(&SourceOption::Mount) && !address.has_robot() {
        base.mount = Some(Mount { height_m: 0.5, ..Mount::default() });
    }
    if !honored.contains(&SourceOption::End) {
        base.range = SequenceRange::default();
    }
    base
}

#[test]
fn examples_open_as_they_are() {
    let place = Place::new();
    for kind in KINDS.iter().filter(|kind| kind.schemes != ["ros2"]) {
        for example in place.examples(kind.name) {
            for purpose in Purpose::ALL {
                let result = everything(&example.text, &base_for(purpose, &example), purpose, kind.is_live);
                let is_room = example.text == "sim:room" && purpose == Purpose::Frames;
                let is_good = result
                    .as_ref()
                    .is_ok_and(|all| !all.is_empty() && !all.iter().any(|one| one.contains("ended")));
                assert_eq!(is_good, !is_room, "{} for {purpose:?}: {result:?}", example.text);
            }
        }
    }
}
