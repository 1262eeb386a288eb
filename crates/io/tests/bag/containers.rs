//! The same recording in SQLite, as a ROS 1 bag and in MCAP.
//!
//! `R1-first-frames.db3` and `.bag` are the first frames of `R1-excerpt.mcap`, written with the Python package rosbags
//! (`interop/ros2/make_bags.py`).

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use visloc_core::{Source, SourceFrame};
use visloc_io::bag::{BagError, BagMessage, BagMessages, BagPictures, BagReader, BagTopics, BagWriter};

use crate::support::{read, read_with, testdata};

const FOREIGN: [&str; 2] = ["R1-first-frames.db3", "R1-first-frames.bag"];
const NUM_FRAMES: usize = 6;

fn messages(path: &Path) -> Vec<BagMessage> {
    let mut bag = BagMessages::open(path).unwrap();
    std::iter::from_fn(|| bag.next_message()).map(|message| message.unwrap()).collect()
}

/// Messages of each topic with their times.
fn by_topic(messages: &[BagMessage]) -> BTreeMap<String, Vec<(u64, Vec<u8>)>> {
    let mut topics = BTreeMap::<String, Vec<_>>::new();
    for message in messages {
        topics
            .entry(message.channel.topic.clone())
            .or_default()
            .push((message.log_nanos, message.data.clone()));
    }
    topics
}

#[test]
fn frames_are_those_of_mcap() {
    let expected: Vec<SourceFrame> = read(&testdata("R1-excerpt.mcap")).frames[..NUM_FRAMES].to_vec();
    for name in FOREIGN {
        let bag = BagReader::open(testdata(name), BagTopics::default()).unwrap();
        assert_eq!((bag.status().num_items, bag.available_topics().len()), (Some(NUM_FRAMES), 6), "{name}");
        let found = read_with(bag);
        assert!(found.error.is_none() && found.skipped.is_empty(), "{name}: {:?}", found.skipped);
        assert_eq!(found.frames.len(), NUM_FRAMES);
        for (mut found, mut expected) in found.frames.into_iter().zip(expected.clone()) {
            // Has no stamp of its own, and these files do not tell when a message was sent, only when it was recorded.
            (found.frame.ground_contact, expected.frame.ground_contact) = (None, None);
            assert!(format!("{found:?}") == format!("{expected:?}"), "{name}: {}", expected.frame.at);
        }
    }
}

#[test]
fn messages_are_those_of_mcap_byte_for_byte() {
    let mut expected = by_topic(&messages(&testdata("R1-excerpt.mcap")));
    for name in FOREIGN {
        let found = by_topic(&messages(&testdata(name)));
        assert_eq!(found.len(), 6);
        for (topic, found) in &found {
            let expected = expected.get_mut(topic).unwrap();
            expected.truncate(found.len());
            assert!(found == expected, "{name}: {topic}");
        }
    }
}

#[test]
fn copies_have_all_messages_in_the_same_order() {
    let folder = tempfile::tempdir().unwrap();
    for name in FOREIGN {
        let path = folder.path().join(name).with_extension("mcap");
        let original = messages(&testdata(name));
        let mut writer = BagWriter::create(&path, BagTopics::default()).unwrap();
        original.iter().for_each(|message| writer.write_copy(message).unwrap());
        writer.finish().unwrap();
        assert!(messages(&path) == original, "{name}");
        assert_eq!(read(&path).frames.len(), NUM_FRAMES);
        for message in &original {
            let schema = String::from_utf8(message.channel.schema.clone()).unwrap();
            assert!(!schema.contains("uint32 seq"), "{schema}");
        }
    }
}

#[test]
fn nothing_is_written_beside_a_database() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a b%20?.db3");
    fs::copy(testdata("R1-first-frames.db3"), &path).unwrap();
    let before = fs::read(&path).unwrap();
    assert_eq!(read(&path).frames.len(), NUM_FRAMES);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(fs::read(&path).unwrap() == before);
    fs::write(folder.path().join("a b%20?.db3-wal"), "left behind").unwrap();
    let Err(error) = BagReader::open(&path, BagTopics::default()) else { panic!("opened") };
    assert!(error.to_string().contains("wal_checkpoint"), "{error}");
}

#[test]
fn the_only_images_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("renamed.mcap");
    let mut writer = BagWriter::create(&path, BagTopics::default()).unwrap();
    for mut message in messages(&testdata("R1-first-frames.db3")) {
        let mut channel = (*message.channel).clone();
        channel.topic = channel.topic.replace("/camera/", "/eye/").replace("/odom", "/wheels");
        message.channel = channel.into();
        writer.write_copy(&message).unwrap();
    }
    writer.finish().unwrap();
    let bag = BagReader::open(&path, BagTopics::default()).unwrap();
    let topics = bag.topics().clone();
    assert_eq!((&*topics.image, &*topics.camera_info), ("/eye/image/compressed", "/eye/camera_info"));
    let frames = read_with(bag).frames;
    assert!(frames.len() == NUM_FRAMES && frames.iter().all(|frame| frame.frame.odometry.is_some()));
    let mut pictures = BagPictures::open(&path, &BagTopics::default()).unwrap();
    assert!(pictures.camera().is_some());
    let picture = pictures.next_item().unwrap().unwrap();
    assert!(picture.file.unwrap().starts_with(&[0xff, 0xd8]));
}

/// Opens and reads it to the end, whatever becomes of it.
fn try_all(path: &Path) -> Result<(usize, usize), BagError> {
    if let Ok(mut bag) = BagReader::open(path, BagTopics::default()) {
        while bag.next_item().is_some() {}
    }
    let mut bag = BagMessages::open(path)?;
    let (mut num_messages, mut num_damages) = (0, 0);
    while let Some(next) = bag.next_message() {
        match next {
            Ok(_) => num_messages += 1,
            Err(damage) => {
                assert!(!damage.reason.is_empty());
                num_damages += 1;
            }
        }
    }
    Ok((num_messages, num_damages))
}

fn damaged(name: &str, folder: &Path, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn cut_and_flipped_files_never_panic_and_are_told() {
    let folder = tempfile::tempdir().unwrap();
    for name in FOREIGN {
        let bytes = fs::read(testdata(name)).unwrap();
        let num_all = messages(&testdata(name)).len();
        for tenth in 0..10 {
            let path = damaged(name, folder.path(), &bytes[..bytes.len() * tenth / 10]);
            match try_all(&path) {
                Ok((num_messages, num_damages)) => {
                    assert!(num_damages > 0 || num_messages == num_all, "{name}: {tenth} tenths");
                }
                Err(error) => assert!(error.to_string().contains("expected"), "{error}"),
            }
        }
        for i in 0..60 {
            let mut flipped = bytes.clone();
            let position = (i * 7919 + i * i * 31) % bytes.len();
            flipped[position] ^= 0x5a;
            let _ = try_all(&damaged(name, folder.path(), &flipped));
        }
    }
}

#[test]
fn other_files_under_these_names_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["notes.db3", "notes.bag"] {
        for content in
            [&b""[..], b"not a recording", b"SQLite format 3\0", b"#ROSBAG V1.2\n", b"#ROSBAG V2.0\n"]
        {
            let error = try_all(&damaged(name, folder.path(), content)).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains("expected"), "{error}");
        }
    }
}
