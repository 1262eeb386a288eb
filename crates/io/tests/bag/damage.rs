//! Damaged recordings.

use std::fs;

use mcap::{Compression, WriteOptions};
use visloc_core::{
    Source, SourceError,
    geom::{Camera, PlanarPose},
};
use visloc_io::bag::{
    BagError, BagReader, BagTopics, BagWriterOptions, ChunkCompression, GivenInputs, ImageEncoding, TopicRole,
};

use crate::support::{copy, copy_without_messages, frame, keep, read, testdata, write};

const IMAGE: &str = "/camera/image/compressed";

#[test]
fn cut_files_give_every_frame_before_the_cut_and_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.mcap");
    let bytes = fs::read(testdata("R1-excerpt.mcap")).unwrap();
    let mut last_count = 0;
    for tenth in 1..10 {
        let length = bytes.len() * tenth / 10;
        fs::write(&path, &bytes[..length]).unwrap();
        let back = read(&path);
        let Some(SourceError::Broken { origin, reason }) = back.error else { panic!("no error at {length}") };
        assert!(origin.contains("cut.mcap") && origin.contains(&format!("byte {length}")), "{origin}");
        assert!(reason.contains("expected") && reason.contains("end of the file"), "{reason}");
        // nine seconds of pictures of about equal size
        assert!(back.frames.len().abs_diff(9 * tenth) <= 3, "{} frames of {tenth} tenths", back.frames.len());
        assert!(back.frames.len() > last_count);
        last_count = back.frames.len();
    }
}

#[test]
fn cuts_in_the_index_and_the_end_mark_lose_no_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.mcap");
    write(&path, &(0..5).map(frame).collect::<Vec<_>>(), BagWriterOptions::default());
    let bytes = fs::read(&path).unwrap();
    for num_missing in [1, 8, 20, 100] {
        fs::write(&path, &bytes[..bytes.len() - num_missing]).unwrap();
        let bag = BagReader::open(&path, BagTopics::default()).unwrap();
        assert_eq!(bag.status().num_items, Some(5));
        let back = read(&path);
        assert!(back.frames.len() == 5 && back.error.is_some());
    }
}

#[test]
fn every_cut_of_a_compressed_file_is_handled() {
    let folder = tempfile::tempdir().unwrap();
    for chunk_compression in [ChunkCompression::None, ChunkCompression::Zstd, ChunkCompression::Lz4] {
        let path = folder.path().join("cut.mcap");
        let options = BagWriterOptions {
            chunk_compression,
            image_encoding: ImageEncoding::Raw,
            ..BagWriterOptions::default()
        };
        write(&path, &(0..2).map(frame).collect::<Vec<_>>(), options);
        let bytes = fs::read(&path).unwrap();
        for length in (0..bytes.len()).step_by(37) {
            fs::write(&path, &bytes[..length]).unwrap();
            match BagReader::open(&path, BagTopics::default()) {
                Ok(mut bag) => while bag.next_item().is_some() {},
                Err(error) => {
                    let is_expected = matches!(
                        error,
                        BagError::NotMcap { .. }
                            | BagError::MissingTopic { .. }
                            | BagError::NoMessages { .. }
                    );
                    assert!(is_expected, "{error}");
                }
            }
        }
    }
}

#[test]
fn topics_without_messages_are_told_with_what_can_be_given_instead() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty-topic.mcap");
    for (topic, instead) in [
        (IMAGE, "--topics"),
        ("/camera/camera_info", "--camera FILE"),
        ("/tf", "--camera-height METERS --camera-tilt DEGREES"),
    ] {
        copy_without_messages(&testdata("R1-excerpt.mcap"), &path, topic);
        let Err(error) = BagReader::open(&path, BagTopics::default()) else { panic!("opened") };
        assert!(matches!(error, BagError::NoMessages { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains(topic) && text.contains("no messages") && text.contains(instead), "{text}");
    }
    // What is not needed may be silent, unless somebody names it.
    copy_without_messages(&testdata("R1-excerpt.mcap"), &path, "/odom");
    assert_eq!(read(&path).frames.len(), 90);
    let other = folder.path().join("other-topic.mcap");
    copy(&path, &other, WriteOptions::new(), |topic, _, data| {
        keep(if topic == "/foot_contact" { "/feet" } else { topic }, data)
    });
    assert_eq!(read(&other).frames.len(), 90, "other names that nobody asked for are chosen");
    let named = GivenInputs { named: vec![TopicRole::Odometry], ..GivenInputs::default() };
    let Err(error) = BagReader::open_with(&path, &BagTopics::default(), named.clone()) else {
        panic!("opened")
    };
    let text = error.to_string();
    assert!(text.contains("/odom") && text.contains("no messages"), "{text}");
    assert!(BagReader::open_with(testdata("R1-excerpt.mcap"), &BagTopics::default(), named).is_ok());
}

#[test]
fn files_of_other_kinds_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.mcap");
    for content in [&b""[..], b"not a recording", &[0; 100_000]] {
        fs::write(&path, content).unwrap();
        let Err(error) = BagReader::open(&path, BagTopics::default()) else { panic!("opened") };
        let text = error.to_string();
        assert!(text.contains("notes.mcap") && text.contains("expected"), "{text}");
    }
}

#[test]
fn flipped_bytes_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flipped.mcap");
    write(&path, &(0..3).map(frame).collect::<Vec<_>>(), BagWriterOptions::default());
    let bytes = fs::read(&path).unwrap();
    for position in (0..bytes.len()).step_by(13) {
        let mut flipped = bytes.clone();
        flipped[position] ^= 0x5a;
        fs::write(&path, &flipped).unwrap();
        if let Ok(mut bag) = BagReader::open(&path, BagTopics::default()) {
            while bag.next_item().is_some() {}
        }
    }
}

#[test]
fn files_without_summary_or_chunks_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.mcap");
    let plain = WriteOptions::new()
        .use_chunks(false)
        .emit_summary_records(false)
        .emit_statistics(false)
        .repeat_channels(false)
        .compression(None);
    copy(&testdata("R1-excerpt.mcap"), &path, plain, |topic, _, data| keep(topic, data));
    let back = read(&path);
    assert!(back.frames.len() == 90 && back.error.is_none());
    let packed = WriteOptions::new().compression(Some(Compression::Zstd)).chunk_size(Some(50_000));
    copy(&testdata("R1-excerpt.mcap"), &path, packed, |topic, _, data| keep(topic, data));
    assert_eq!(read(&path).frames.len(), 90);
}

#[test]
fn a_damaged_picture_costs_one_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.mcap");
    copy(&testdata("R1-excerpt.mcap"), &path, WriteOptions::new(), |topic, index, data| {
        let mut data = data.to_vec();
        if topic == IMAGE && index == 40 {
            data[80..].fill(0x77);
        }
        if topic == IMAGE && index == 50 {
            data.truncate(30);
        }
        Some((topic.to_string(), data))
    });
    let back = read(&path);
    assert_eq!((back.frames.len(), back.skipped.len()), (88, 2));
    let (topic, reason) = &back.skipped[0];
    assert!(topic == IMAGE && reason.contains("JPEG"), "{reason}");
}

#[test]
fn a_wrong_checksum_is_reported_and_reading_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checksum.mcap");
    let mut bytes = fs::read(testdata("R1-excerpt.mcap")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).unwrap();
    let back = read(&path);
    assert!(back.error.is_none() && back.frames.len() >= 89);
    assert!(back.skipped.iter().any(|(_, reason)| reason.contains("checksum")), "{:?}", back.skipped);
}

#[test]
fn odometry_that_is_no_number_is_left_out_and_never_handed_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nan.mcap");
    let mut frames: Vec<_> = (0..20).map(frame).collect();
    frames[5].frame.odometry = Some(PlanarPose { x_m: f64::NAN, y_m: 0.0, yaw_rad: 0.0 });
    frames[6].frame.odometry = Some(PlanarPose { x_m: 0.0, y_m: 0.0, yaw_rad: f64::INFINITY });
    write(&path, &frames, BagWriterOptions::default());
    let back = read(&path);
    assert_eq!((back.frames.len(), back.skipped.len()), (20, 2));
    assert!(
        back.skipped.iter().all(|(topic, reason)| topic == "/odom" && reason.contains("NaN")),
        "{:?}",
        back.skipped
    );
    assert!(back.frames.iter().all(|frame| frame.frame.odometry.unwrap().is_finite()));
    // between frames 4 and 7, which are 0.3 s apart, the pose is interpolated
    assert!((back.frames[5].frame.odometry.unwrap().x_m - 0.5).abs() < 1e-9);
}

#[test]
fn pictures_of_another_size_are_left_out_and_a_wrong_calibration_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("size.mcap");
    let other = Camera::pinhole((640, 480), (70.0, 70.0), (32.0, 24.0)).unwrap();
    let mut frames: Vec<_> = (0..30).map(frame).collect();
    frames[3].frame.camera = other;
    write(&path, &frames, BagWriterOptions::default());
    let back = read(&path);
    assert!(back.error.is_none() && back.frames.len() == 29);
    assert!(back.skipped[0].1.contains("640 x 480") && back.skipped[0].1.contains("64 x 48"));
    for frame in &mut frames {
        frame.frame.camera = other;
    }
    write(&path, &frames, BagWriterOptions::default());
    let back = read(&path);
    let error = back.error.unwrap().to_string();
    assert!(back.frames.is_empty() && error.contains("/camera/camera_info"), "{error}");
}

#[test]
fn messages_that_go_back_in_time_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("back.mcap");
    let mut frames: Vec<_> = (0..20).map(frame).collect();
    frames[10].frame.at = crate::support::at(2);
    write(&path, &frames, BagWriterOptions::default());
    let back = read(&path);
    assert_eq!(back.frames.len(), 19);
    assert!(back.frames.windows(2).all(|pair| pair[0].frame.at < pair[1].frame.at));
    let topics: std::collections::BTreeSet<_> =
        back.skipped.iter().map(|(topic, _)| topic.as_str()).collect();
    assert!(topics.contains(IMAGE) && topics.contains("/odom") && topics.contains("/tf"), "{topics:?}");
}

#[test]
fn a_recording_of_which_nothing_can_be_used_says_why() {
    let topics = BagTopics { base_frame: "pelvis".into(), ..BagTopics::default() };
    let mut bag = BagReader::open(testdata("R1-excerpt.mcap"), topics).unwrap();
    let error = bag.next_item().unwrap().unwrap_err().to_string();
    assert!(error.contains("none of its 90 images"), "{error}");
    assert!(error.contains("pelvis") && error.contains("base_footprint -> camera_optical"), "{error}");
    assert_eq!(bag.status().skipped.len(), 90);
}
