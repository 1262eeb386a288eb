//! Sources from their argument to their images. A small script stands in for ffmpeg, so that the pipe, the times, the end
//! and all that can go wrong are tried without it.
#![cfg(unix)]
#![allow(clippy::unwrap_used)]

mod programs;

use std::{fs, path::PathBuf};

use programs::write_program;
use tempfile::TempDir;
use visloc_core::{
    Frame, Host, ImageSource, RgbImage, SourceError, SourceFrame, Timestamp,
    geom::{Camera, Mount, PlanarPose},
};
use visloc_io::{
    bag::{BagTopics, BagWriter},
    image_codec::save_png,
    sources::{SourceOptions, SourcesError, TopicOptions, open_frames, open_images, open_pictures},
};

const CALIBRATION: &str =
    "model = \"pinhole\"\nsize_px = [2, 2]\nfocal_px = [2.0, 2.0]\ncenter_px = [0.5, 0.5]\n";

/// A folder with a calibration, a video that is none, and a program in place of ffmpeg.
struct Place {
    folder: TempDir,
}

impl Place {
    /// The program writes so many images of 2 x 2 px and then does what `end` says.
    fn new(num_images: u32, end: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("camera.toml"), CALIBRATION).unwrap();
        fs::write(folder.path().join("clip.mp4"), "").unwrap();
        let script = format!(
            "#!/bin/sh\n[ \"$1\" = -version ] && echo 'ffmpeg version 5.1.9' && exit 0\n\
             i=0\nwhile [ $i -lt {num_images} ]; do\n\
             echo \"[x] [info] n: $i pts_time:0.$((i + 1))0 fmt:gray\" >&2\n\
             printf 'P5\\n2 2\\n255\\n\\10\\20\\30\\40'\ni=$((i + 1))\ndone\n{end}\n"
        );
        write_program(&folder.path().join("ffmpeg"), &script);
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    fn options(&self) -> SourceOptions {
        SourceOptions {
            ffmpeg: Some(self.path("ffmpeg")),
            camera: Some(self.path("camera.toml")),
            ..SourceOptions::default()
        }
    }

    fn images(&self) -> Box<dyn ImageSource> {
        open_images(&self.text("clip.mp4"), &self.options(), &Host::silent()).unwrap().images
    }
}

/// Stamps of all images, and the error at the end.
fn drain(images: &mut dyn ImageSource) -> (Vec<Timestamp>, Option<SourceError>) {
    let mut stamps = Vec::new();
    while let Some(next) = images.next_item() {
        match next {
            Ok(frame) => {
                assert_eq!(frame.image.data(), [8, 16, 24, 32]);
                stamps.push(frame.at);
            }
            Err(error) => return (stamps, Some(error)),
        }
    }
    (stamps, None)
}

#[test]
fn a_video_keeps_its_times() {
    let place = Place::new(3, "exit 0");
    let mut images = place.images();
    assert_eq!(images.camera().focal_px(), (2.0, 2.0));
    let (stamps, error) = drain(images.as_mut());
    assert_eq!(stamps, [0.1, 0.2, 0.3].map(Timestamp::from_secs));
    assert!(error.is_none() && images.status().skipped.is_empty());
}

#[test]
fn what_came_before_the_damage_is_kept() {
    for (end, expected) in [
        ("printf 'P5\\n2 2\\n255\\n\\10'; exit 0", "the last image is cut off (after 3 images)"),
        (
            "echo '[h264] [error] corrupt frame' >&2; exit 4",
            "after 3 images with exit status: 4: corrupt frame",
        ),
        ("printf 'RIFF and so on'; exit 0", "expected an image as PGM or PPM"),
    ] {
        let (stamps, error) = drain(Place::new(3, end).images().as_mut());
        let error = error.unwrap().to_string();
        assert!(stamps.len() == 3 && error.contains(expected), "{error} ({expected})");
    }
    let place = Place::new(2, "echo '[mkv] [error] ended prematurely' >&2; exit 0");
    let mut images = place.images();
    assert!(drain(images.as_mut()).1.is_none());
    assert_eq!(images.status().skipped[0].reason, "ended prematurely");
}

#[test]
fn a_video_without_images_or_program_says_why() {
    let place = Place::new(0, "echo '[mov] [error] moov atom not found' >&2; exit 183");
    let open = |options: &SourceOptions| {
        let result = open_images(&place.text("clip.mp4"), options, &Host::silent());
        result.err().unwrap().to_string()
    };
    assert!(open(&place.options()).contains("after 0 images with exit status: 183: moov atom not found"));
    let missing = SourceOptions { ffmpeg: Some(place.path("nothing")), ..place.options() };
    assert!(open(&missing).contains("cannot be started") && open(&missing).contains("apt install ffmpeg"));
    assert!(open(&SourceOptions { camera: None, ..place.options() }).contains("--camera FILE"));
    let text = format!("video:{}", place.text("none.mp4"));
    let error = open_images(&text, &place.options(), &Host::silent()).err().unwrap().to_string();
    assert!(error.contains("expected a video file"), "{error}");
}

#[test]
fn frames_of_a_video_have_the_mount_and_nothing_else() {
    let place = Place::new(2, "exit 0");
    let video = place.text("clip.mp4");
    let error = open_frames(&video, &place.options(), &Host::silent()).err().unwrap();
    assert!(matches!(error, SourcesError::NoMount { .. }), "{error}");
    let mount = Some(Mount { height_m: 0.5, ..Mount::default() });
    let options = SourceOptions { mount, ..place.options() };
    let mut frames = open_frames(&video, &options, &Host::silent()).unwrap().frames;
    let frame = frames.next_item().unwrap().unwrap().frame;
    assert_eq!((frame.image.get(1, 1), frame.odometry), ([32; 3], None));
    assert_eq!(frame.robot_from_camera.translation().z, 0.5);
}

#[test]
fn a_live_source_gives_the_newest_and_counts_the_rest() {
    let place = Place::new(9, "exit 0");
    fs::create_dir(place.path("photos")).unwrap();
    save_png(&RgbImage::new(2, 2), &place.path("photos/1.png")).unwrap();
    fs::write(place.path("clip.MP4"), "").unwrap();
    for name in ["photos", "clip.MP4"] {
        let text = format!("loop:{}", place.text(name));
        let mut pictures = open_pictures(&text, &place.options(), &Host::silent()).unwrap().pictures;
        let mut num_seen = 0;
        while let Some(next) = pictures.next_item() {
            next.unwrap();
            num_seen += 1;
        }
        assert!(num_seen >= 1);
        assert_eq!(num_seen + pictures.status().num_dropped, 9, "{name}");
    }
    let missing = open_pictures("v4l2:/dev/no-such-camera", &place.options(), &Host::silent());
    assert!(missing.err().unwrap().to_string().contains("expected a camera such as /dev/video0"));
}

#[test]
fn folders_and_bags_serve_every_purpose() {
    let place = Place::new(0, "exit 1");
    for name in ["1.png", "2.png"] {
        save_png(&RgbImage::new(2, 2), &place.path(name)).unwrap();
    }
    let folder = place.folder.path().display().to_string();
    let options = SourceOptions { rate_hz: Some(10.0), ffmpeg: None, ..place.options() };
    let mut images = open_images(&format!("images:{folder}"), &options, &Host::silent()).unwrap().images;
    images.next_item();
    assert_eq!(images.next_item().unwrap().unwrap().at, Timestamp::from_secs(0.1));
    let uncalibrated = SourceOptions { camera: None, ..options };
    assert!(open_pictures(&folder, &uncalibrated, &Host::silent()).unwrap().pictures.next_item().is_some());
    let error = open_images(&format!("tum:{folder}"), &uncalibrated, &Host::silent()).err().unwrap();
    assert!(error.to_string().contains("rgb.txt (TUM RGB-D); it is not there"), "{error}");

    let bag = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/R1-excerpt.mcap");
    let options = SourceOptions {
        topics: all(BagTopics { tf: String::new(), ..BagTopics::default() }),
        ..SourceOptions::default()
    };
    let images = open_images(bag, &options, &Host::silent()).unwrap().images;
    assert_eq!((images.camera().size_px(), images.status().num_items), ((320, 240), Some(90)));
}

#[test]
fn rooms_are_no_fields() {
    let open = |text: &str| open_frames(text, &SourceOptions::default(), &Host::silent());
    assert!(open("sim:room").err().unwrap().to_string().contains("visloc slam"));
    let robot = open("sim:robocup").unwrap();
    assert!(robot.map.is_some() && robot.frames.status().num_items.is_some());
}

fn all(topics: BagTopics) -> TopicOptions {
    TopicOptions { all: Some(topics), ..TopicOptions::default() }
}

/// A bag of three images of 2 x 2 px with odometry, and of calibration and tf what `topics` names.
fn small_bag(place: &Place, topics: &BagTopics) -> String {
    let path = place.path("robot.mcap");
    let mut writer = BagWriter::create(&path, topics.clone()).unwrap();
    for i in 0..3 {
        let frame = Frame {
            at: Timestamp::from_secs(100.0 + 0.1 * f64::from(i)),
            image: RgbImage::new(2, 2),
            camera_index: 0,
            camera: Camera::pinhole((2, 2), (3.0, 3.0), (0.5, 0.5)).unwrap(),
            robot_from_camera: Mount { height_m: 0.4, ..Mount::default() }.robot_from_camera(),
            odometry: Some(PlanarPose::new(0.1 * f64::from(i), 0.0, 0.0)),
            ground_contact: None,
        };
        writer.write(&SourceFrame { frame, truth: None }).unwrap();
    }
    writer.finish().unwrap();
    path.display().to_string()
}

#[test]
fn camera_and_mount_are_used_over_and_instead_of_what_a_bag_says() {
    let place = Place::new(0, "exit 1");
    let mount = Mount { height_m: 0.5, tilt_rad: 0.3, ..Mount::default() };
    let both = SourceOptions { mount: Some(mount), ffmpeg: None, ..place.options() };
    let bare_topics = BagTopics {
        camera_info: String::new(),
        tf: String::new(),
        tf_static: String::new(),
        ..BagTopics::default()
    };
    let open = |bag: &str, options: &SourceOptions| open_frames(bag, options, &Host::silent());
    for topics in [BagTopics::default(), bare_topics.clone()] {
        let bag = small_bag(&place, &topics);
        let mut frames = open(&bag, &both).unwrap().frames;
        let frame = frames.next_item().unwrap().unwrap().frame;
        assert_eq!(frame.camera.focal_px(), (2.0, 2.0));
        assert_eq!(frame.robot_from_camera, mount.robot_from_camera());
        assert!(frame.odometry.is_some(), "the robot's odometry stays");
    }
    // Without them the bag lacks what they stand for, and so it does if its topics are not to be read.
    let bag = small_bag(&place, &bare_topics);
    let error = open(&bag, &SourceOptions { camera: None, ..both.clone() }).err().unwrap().to_string();
    assert!(error.contains("/camera/camera_info") && error.contains("--camera FILE"), "{error}");
    let error = open(&bag, &SourceOptions { mount: None, ..both }).err().unwrap().to_string();
    assert!(error.contains("/tf") && error.contains("--camera-height"), "{error}");
    let options = SourceOptions { topics: all(bare_topics), ..SourceOptions::default() };
    let error = open(&small_bag(&place, &BagTopics::default()), &options).err().unwrap().to_string();
    assert!(error.contains("is set to \"\"") && error.contains("--camera FILE"), "{error}");
}
