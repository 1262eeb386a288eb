//! What is written comes back.

use visloc_core::GroundContact;
use visloc_io::bag::{BagReader, BagTopics, BagWriter, BagWriterOptions, ChunkCompression, ImageEncoding};

use crate::support::{at, frame, read, read_with, write};

#[test]
fn frames_come_back_equal_with_every_compression_and_image_encoding() {
    let folder = tempfile::tempdir().unwrap();
    let frames: Vec<_> = (0..12).map(frame).collect();
    for chunk_compression in [ChunkCompression::None, ChunkCompression::Zstd, ChunkCompression::Lz4] {
        for image_encoding in [ImageEncoding::Raw, ImageEncoding::Png, ImageEncoding::Jpeg { quality: 95 }] {
            let path = folder.path().join("round.mcap");
            write(&path, &frames, BagWriterOptions { image_encoding, chunk_compression, has_chunks: true });
            let back = read(&path);
            assert!(back.error.is_none() && back.skipped.is_empty(), "{:?} {:?}", back.error, back.skipped);
            assert_eq!(back.frames.len(), frames.len());
            for (written, found) in frames.iter().zip(&back.frames) {
                let (a, b) = (&written.frame, &found.frame);
                assert_eq!((a.at, a.camera, a.ground_contact), (b.at, b.camera, b.ground_contact));
                assert!((a.robot_from_camera.rotation() - b.robot_from_camera.rotation()).norm() < 1e-12);
                assert_eq!(a.robot_from_camera.translation(), b.robot_from_camera.translation());
                let (odometry, odometry_back) = (a.odometry.unwrap(), b.odometry.unwrap());
                assert!(odometry.distance_m(&odometry_back) < 1e-12);
                assert!(odometry.heading_difference_rad(&odometry_back) < 1e-12);
                assert_eq!(written.truth.unwrap().height_m, found.truth.unwrap().height_m);
                if !matches!(image_encoding, ImageEncoding::Jpeg { .. }) {
                    assert_eq!(a.image, b.image);
                }
            }
        }
    }
}

#[test]
fn a_folder_gets_its_metadata_and_is_read_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk");
    let frames: Vec<_> = (0..5).map(frame).collect();
    write(&path, &frames, BagWriterOptions::default());
    let yaml = std::fs::read_to_string(path.join("metadata.yaml")).unwrap();
    assert!(yaml.contains("walk_0.mcap") && yaml.contains("message_count: 30"), "{yaml}");
    assert_eq!(read(&path).frames.len(), 5);
}

#[test]
fn without_a_message_nothing_is_left_and_an_earlier_recording_stays() {
    let folder = tempfile::tempdir().unwrap();
    let create = |name: &str| BagWriter::create(folder.path().join(name), BagTopics::default());
    std::fs::write(folder.path().join("earlier.mcap"), "kept").unwrap();
    for name in ["new.mcap", "walk", "earlier.mcap"] {
        create(name).unwrap().finish().unwrap();
        drop(create(name).unwrap());
    }
    let names = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert_eq!(names.collect::<Vec<_>>(), ["earlier.mcap"]);
    assert_eq!(std::fs::read_to_string(folder.path().join("earlier.mcap")).unwrap(), "kept");
    assert!(create("earlier.mcap/below.mcap").is_err(), "told before the first message");
}

#[test]
fn parts_that_a_frame_lacks_are_not_made_up() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bare.mcap");
    let mut bare = frame(0);
    bare.frame.odometry = None;
    bare.frame.ground_contact = None;
    bare.truth = None;
    write(&path, &[bare], BagWriterOptions::default());
    let back = read(&path).frames.remove(0);
    assert!(back.frame.odometry.is_none() && back.frame.ground_contact.is_none() && back.truth.is_none());
}

#[test]
fn truth_can_be_left_out_and_topics_renamed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("renamed.mcap");
    let topics = BagTopics { image: "/eye".into(), camera_frame: Some("eye".into()), ..BagTopics::default() };
    let mut writer = BagWriter::create(&path, topics.clone()).unwrap();
    let mut with_contact = frame(0);
    with_contact.frame.ground_contact = Some(GroundContact::Contact(false));
    writer.write(&with_contact).unwrap();
    writer.finish().unwrap();
    let back = read_with(BagReader::open(&path, topics).unwrap().without_truth());
    assert_eq!(back.frames[0].frame.ground_contact, Some(GroundContact::Contact(false)));
    assert!(back.frames[0].truth.is_none());
}

/// As if the program had been killed: the file ends wherever it ends.
#[test]
fn other_readers_get_all_but_the_last_half_second_of_a_killed_program() {
    let folder = tempfile::tempdir().unwrap();
    for (num_frames, secs) in [(1, 0.0), (27, 2.6)] {
        for has_chunks in [true, false] {
            // Each in a file of its own: this program lives on, and keeps those of its writers that are forgotten.
            let path = folder.path().join(format!("killed-{num_frames}-{has_chunks}.mcap"));
            let options = BagWriterOptions { has_chunks, ..BagWriterOptions::default() };
            let mut writer = BagWriter::create_with(&path, BagTopics::default(), options).unwrap();
            for index in 0..num_frames {
                writer.write(&frame(index)).unwrap();
            }
            // Not even its buffers are written.
            std::mem::forget(writer);
            let bytes = std::fs::read(&path).unwrap();
            let options = mcap::read::Options::IgnoreEndMagic.into();
            let stream = mcap::MessageStream::new_with_options(&bytes, options).unwrap();
            let stamps: Vec<u64> = stream.map_while(Result::ok).map(|message| message.log_time).collect();
            let first = u64::try_from(at(0).nanos()).unwrap();
            let last_secs = (stamps.last().unwrap() - first) as f64 * 1e-9;
            assert!(last_secs >= secs - 0.5 - 1e-9, "{num_frames} {has_chunks}: {last_secs} s");
        }
    }
}
