//! Frames, recordings and damaged copies of them.

use std::{
    fs::{self, File},
    io::BufWriter,
    path::{Path, PathBuf},
};

use mcap::{Message, MessageStream, WriteOptions};
use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    Frame, GroundContact, RgbImage, Source, SourceError, SourceFrame, Timestamp, Truth,
    geom::{Camera, Distortion, PlanarPose, Rigid3},
};
use visloc_io::{
    bag::{BagReader, BagTopics, BagWriter, BagWriterOptions, EncodedImage, ImagePayload, SensorMessage},
    image_codec,
};

/// Path of a recording in `testdata`.
pub fn testdata(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata").join(name)
}

/// Ten frames a second.
pub fn at(index: usize) -> Timestamp {
    Timestamp::from_nanos(1_700_000_000_000_000_000 + index as i64 * 100_000_000)
}

pub fn frame(index: usize) -> SourceFrame {
    let phase = index as f64 * 0.1;
    let mut image = RgbImage::new(64, 48);
    for (i, byte) in image.data_mut().iter_mut().enumerate() {
        *byte = ((i / 3 + index) % 200) as u8;
    }
    let distortion = Distortion::RadialTangential([-0.1, 0.02, 1e-3, -1e-3, 0.001]);
    let rotation = Rotation3::from_scaled_axis(Vector3::new(-1.2, 1.1 + 0.1 * phase.sin(), -1.2));
    SourceFrame {
        frame: Frame {
            at: at(index),
            image,
            camera_index: 0,
            camera: Camera::new((64, 48), (70.0, 71.0), (31.5, 23.5), distortion).unwrap(),
            robot_from_camera: Rigid3::new(rotation, Vector3::new(0.05, 0.01 * phase.sin(), 0.5)),
            odometry: Some(PlanarPose::new(phase, -phase, phase)),
            ground_contact: Some(GroundContact::Pressure([phase; 8])),
        },
        truth: Some(Truth { world_from_robot: PlanarPose::new(1.0, phase, 0.3), height_m: 0.01 * phase }),
    }
}

/// A picture of the frame `camera`, as it comes on a topic.
pub fn picture(at: Timestamp) -> SensorMessage {
    let bytes = image_codec::encode_png(&frame(0).frame.image).unwrap();
    let payload = ImagePayload::Compressed(bytes);
    SensorMessage::Image(EncodedImage { at, frame_id: "camera".into(), payload })
}

pub fn write(path: &Path, frames: &[SourceFrame], options: BagWriterOptions) {
    let mut writer = BagWriter::create_with(path, BagTopics::default(), options).unwrap();
    for frame in frames {
        writer.write(frame).unwrap();
    }
    writer.finish().unwrap();
}

/// All frames, the error at the end, and what was left out.
pub struct Read {
    pub frames: Vec<SourceFrame>,
    pub error: Option<SourceError>,
    /// Topic and reason.
    pub skipped: Vec<(String, String)>,
}

pub fn read(path: &Path) -> Read {
    read_with(BagReader::open(path, BagTopics::default()).unwrap())
}

pub fn read_with(mut bag: BagReader) -> Read {
    let (mut frames, mut error) = (Vec::new(), None);
    while let Some(next) = bag.next_item() {
        assert!(error.is_none(), "a frame after the error");
        match next {
            Ok(frame) => frames.push(frame),
            Err(source_error) => error = Some(source_error),
        }
    }
    assert!(bag.next_item().is_none());
    let skipped =
        bag.status().skipped.iter().map(|skip| (skip.origin.clone(), skip.reason.clone())).collect();
    Read { frames, error, skipped }
}

/// Copies a recording; `change` gets the topic, the number of the message in it and its bytes, and returns the new
/// topic and bytes or `None` to leave it out.
pub fn copy(
    from: &Path,
    to: &Path,
    options: WriteOptions,
    mut change: impl FnMut(&str, usize, &[u8]) -> Option<(String, Vec<u8>)>,
) {
    let bytes = fs::read(from).unwrap();
    let mut writer = options.create(BufWriter::new(File::create(to).unwrap())).unwrap();
    let mut counts = std::collections::BTreeMap::<String, usize>::new();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let count = counts.entry(message.channel.topic.clone()).or_default();
        let changed = change(&message.channel.topic, *count, &message.data);
        *count += 1;
        let Some((topic, data)) = changed else { continue };
        let mut channel = (*message.channel).clone();
        // One id per topic, also where a topic was renamed.
        channel.topic = topic;
        writer.write(&Message { channel: channel.into(), data: data.into(), ..message }).unwrap();
    }
    writer.finish().unwrap();
}

/// A copy in which a topic is announced and has no messages.
pub fn copy_without_messages(from: &Path, to: &Path, topic: &str) {
    let bytes = fs::read(from).unwrap();
    let mut writer = WriteOptions::new().create(BufWriter::new(File::create(to).unwrap())).unwrap();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        if message.channel.topic != topic {
            writer.write(&message).unwrap();
            continue;
        }
        let (channel, schema) = (&message.channel, message.channel.schema.as_ref().unwrap());
        let schema_id = writer.add_schema(&schema.name, &schema.encoding, &schema.data).unwrap();
        writer.add_channel(schema_id, topic, &channel.message_encoding, &channel.metadata).unwrap();
    }
    writer.finish().unwrap();
}

pub fn keep(topic: &str, data: &[u8]) -> Option<(String, Vec<u8>)> {
    Some((topic.to_string(), data.to_vec()))
}
