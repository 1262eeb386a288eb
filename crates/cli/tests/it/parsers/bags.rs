//! Recordings and the messages in them.

use std::{fs, path::Path};

use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    Frame, GroundContact, RgbImage, Source, SourceFrame, Timestamp, Truth,
    geom::{Camera, Distortion, PlanarPose, Rigid3},
};
use visloc_io::{
    bag::{
        BagMessages, BagPictures, BagReader, BagTopics, BagWriter, BagWriterOptions, ChunkCompression,
        ExpectedInputs, ImageEncoding, RosMessage, SensorMessage, SyncOutcome, Synchronizer, Transcoder,
        messages::{self, from_cdr, to_cdr},
    },
    image_codec::encode_png,
};

use super::{as_file, in_folder, robots::ROBOT};

/// A small picture of a robot and what else it senses, ten a second.
pub fn frame(index: usize) -> SourceFrame {
    let phase = index as f64 * 0.1;
    let mut image = RgbImage::new(16, 12);
    for (i, byte) in image.data_mut().iter_mut().enumerate() {
        *byte = ((i / 3 + index) % 200) as u8;
    }
    let distortion = Distortion::RadialTangential([-0.1, 0.02, 1e-3, -1e-3, 0.001]);
    let rotation = Rotation3::from_scaled_axis(Vector3::new(-1.2, 1.1, -1.2));
    SourceFrame {
        frame: Frame {
            at: Timestamp::from_nanos(1_700_000_000_000_000_000 + index as i64 * 100_000_000),
            image,
            camera_index: 0,
            camera: Camera::new((16, 12), (17.0, 17.5), (7.5, 5.5), distortion).unwrap(),
            robot_from_camera: Rigid3::new(rotation, Vector3::new(0.05, 0.01, 0.5)),
            odometry: Some(PlanarPose::new(phase, -phase, phase)),
            ground_contact: Some(GroundContact::Pressure([phase; 8])),
        },
        truth: Some(Truth { world_from_robot: PlanarPose::new(1.0, phase, 0.3), height_m: 0.0 }),
    }
}

/// A recording of some frames.
pub fn write(path: &Path, num_frames: usize, options: BagWriterOptions) {
    let mut writer = BagWriter::create_file(path, BagTopics::default(), options).unwrap();
    (0..num_frames).for_each(|index| writer.write(&frame(index)).unwrap());
    writer.finish().unwrap();
}

/// With and without chunks, each compression, each kind of image.
pub fn mcap_seeds() -> Vec<Vec<u8>> {
    let plain = |image_encoding| BagWriterOptions {
        has_chunks: false,
        image_encoding,
        ..BagWriterOptions::default()
    };
    let packed = |chunk_compression| BagWriterOptions { chunk_compression, ..BagWriterOptions::default() };
    let options = [
        plain(ImageEncoding::Raw),
        plain(ImageEncoding::Png),
        plain(BagWriterOptions::default().image_encoding),
        packed(ChunkCompression::None),
        packed(ChunkCompression::Lz4),
        packed(ChunkCompression::Zstd),
    ];
    let mut seeds: Vec<Vec<u8>> = in_folder(|folder| {
        let path = folder.join("seed.mcap");
        let bytes = |options| {
            write(&path, 2, options);
            fs::read(&path).unwrap()
        };
        options.into_iter().map(bytes).collect()
    });
    // Without its index at the end.
    let cut = seeds[0][..seeds[0].len() / 2].to_vec();
    seeds.push(cut);
    seeds
}

pub fn mcap(bytes: &[u8]) {
    as_file("input.mcap", bytes, read_bag);
}

/// Databases with an index by time and without.
pub fn sqlite_seeds() -> Vec<Vec<u8>> {
    let all = ["CREATE INDEX timestamp_idx ON messages (timestamp ASC)", "SELECT 1 WHERE 0"];
    all.map(|index| in_folder(|folder| database(folder, index).unwrap())).into()
}

fn database(folder: &Path, index: &str) -> rusqlite::Result<Vec<u8>> {
    let (bag, path) = (folder.join("seed.mcap"), folder.join("seed.db3"));
    let _ = fs::remove_file(&path);
    write(&bag, 2, BagWriterOptions::default());
    let bytes = fs::read(&bag).unwrap();
    let database = rusqlite::Connection::open(&path)?;
    database.execute_batch(&format!(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL, \
         offered_qos_profiles TEXT NOT NULL); CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, \
         timestamp INTEGER NOT NULL, data BLOB NOT NULL); {index};"
    ))?;
    let mut topics = Vec::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = message.channel.topic.clone();
        let id = topics.iter().position(|known| *known == topic).unwrap_or(topics.len());
        if id == topics.len() {
            let type_name = &message.channel.schema.as_ref().unwrap().name;
            let values = rusqlite::params![id as i64, topic, type_name];
            database.execute("INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr', '')", values)?;
            topics.push(topic);
        }
        let values = rusqlite::params![id as i64, message.log_time as i64, message.data.as_ref()];
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)", values)?;
    }
    drop(database);
    Ok(fs::read(path).unwrap())
}

pub fn sqlite(bytes: &[u8]) {
    as_file("input.db3", bytes, read_bag);
}

const HEADER_DEFINITION: &str = "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";

/// A message of ROS 1 with a picture.
fn ros1_picture(number: u32) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let image = encode_png(&frame(0).frame.image).unwrap();
    let stamp = [1_700_000_000_u32 + number, 0].map(u32::to_le_bytes).concat();
    let length = (image.len() as u32).to_le_bytes();
    [&number.to_le_bytes()[..], &stamp, &text("eye"), &text("png"), &length, &image].concat()
}

fn picture_definition() -> String {
    let rule = "=".repeat(80);
    format!("Header header  # when\nstring format\nuint8[] data\n\n{rule}\n{HEADER_DEFINITION}")
}

/// A record of a ROS 1 bag.
fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let field = |(name, value): &(&str, &[u8])| {
        let field = [name.as_bytes(), b"=", value].concat();
        [&(field.len() as u32).to_le_bytes()[..], &field].concat()
    };
    let header: Vec<u8> = fields.iter().flat_map(field).collect();
    let lengths = [header.len(), data.len()].map(|length| (length as u32).to_le_bytes());
    [&lengths[0][..], &header, &lengths[1], data].concat()
}

/// With a chunk that is not compressed, and what another program wrote.
pub fn ros1_seeds() -> Vec<Vec<u8>> {
    let connection_data = record(
        &[
            ("topic", b"/camera/image/compressed"),
            ("type", b"sensor_msgs/CompressedImage"),
            ("md5sum", b"8f7a12909da2c9d3332d540a0977563f"),
            ("message_definition", picture_definition().as_bytes()),
        ],
        b"",
    );
    let fields = &connection_data[4..connection_data.len() - 4];
    let conn = 0_u32.to_le_bytes();
    let topic: (&str, &[u8]) = ("topic", b"/camera/image/compressed");
    let connection = record(&[("op", &[7]), ("conn", &conn), topic], fields);
    let time = |number: u32| [1_700_000_000 + number, 0].map(u32::to_le_bytes).concat();
    let messages = (0..2).map(|number| {
        record(&[("op", &[2]), ("conn", &conn), ("time", &time(number))], &ros1_picture(number))
    });
    let content = [vec![connection.clone()], messages.collect()].concat().concat();
    let size = (content.len() as u32).to_le_bytes();
    let chunk = record(&[("op", &[5]), ("compression", b"none"), ("size", &size)], &content);
    let magic = b"#ROSBAG V2.0\n".to_vec();
    let counts = [1_u32, 1].map(u32::to_le_bytes);
    let head = |index: usize| {
        let index = (index as u64).to_le_bytes();
        let fields: [(&str, &[u8]); 4] =
            [("op", &[3]), ("index_pos", &index), ("conn_count", &counts[0]), ("chunk_count", &counts[1])];
        record(&fields, &[b' '; 40])
    };
    let at = magic.len() + head(0).len();
    let place = (at as u64).to_le_bytes();
    let info_fields: [(&str, &[u8]); 6] = [
        ("op", &[6]),
        ("ver", &counts[0]),
        ("chunk_pos", &place),
        ("start_time", &time(0)),
        ("end_time", &time(1)),
        ("count", &counts[1]),
    ];
    let info = record(&info_fields, &[conn, 2_u32.to_le_bytes()].concat());
    let whole = [magic, head(at + chunk.len()), chunk, connection, info].concat();
    vec![whole, include_bytes!("../../../../../testdata/R1-first-frames.bag").to_vec()]
}

pub fn ros1(bytes: &[u8]) {
    as_file("input.bag", bytes, read_bag);
}

/// A definition, a zero, and a message.
pub fn definition_seeds() -> Vec<Vec<u8>> {
    let nested = "int8[3] a\nbool b\nfloat64[] c\nstring[] d\nP[] p\nduration t\nint32 X=5\nstring S=a # b\n===\nMSG: q/P\nfloat32 x\nchar y\nbyte[2] z\n";
    vec![
        [picture_definition().as_bytes(), &[0], &ros1_picture(1)].concat(),
        [nested.as_bytes(), &[0], &[1, 0, 0, 0, 1, 0, 0, 0].repeat(8)].concat(),
    ]
}

pub fn definition(bytes: &[u8]) {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let Ok(text) = std::str::from_utf8(&bytes[..end]) else { return };
    let Ok(transcoder) = Transcoder::new("q/M", text) else { return };
    let _ = transcoder.definition();
    if let Ok(data) = transcoder.to_cdr(bytes.get(end + 1..).unwrap_or_default()) {
        assert!(data.len() <= 16 * bytes.len() + 64, "{} bytes of {}", data.len(), bytes.len());
    }
}

/// Reads all frames, pictures and messages.
pub fn read_bag(path: &Path) {
    let topics = BagTopics::default();
    if let Ok(mut bag) = BagReader::open(path, topics.clone()) {
        let mut last = None;
        while let Some(next) = bag.next_item() {
            let Ok(SourceFrame { frame, .. }) = next else { continue };
            assert!(last.is_none_or(|last| last < frame.at), "time increases");
            assert!(frame.odometry.is_none_or(|pose| pose.is_finite()), "finite odometry");
            last = Some(frame.at);
        }
        assert!(bag.next_item().is_none(), "the end stays the end");
    }
    if let Ok(mut messages) = BagMessages::open(path) {
        while messages.next_message().is_some() {}
    }
    if let Ok(mut pictures) = BagPictures::open(path, &topics) {
        while pictures.next_item().is_some() {}
    }
}

/// `metadata.yaml` beside a good file.
pub fn metadata_seeds() -> Vec<Vec<u8>> {
    let text = in_folder(|folder| {
        let path = folder.join("seed-folder");
        let mut writer = BagWriter::create(&path, BagTopics::default()).unwrap();
        writer.write(&frame(0)).unwrap();
        writer.finish().unwrap();
        fs::read(path.join("metadata.yaml")).unwrap()
    });
    vec![text, b"rosbag2_bagfile_information:\n  relative_file_paths:\n    - good.mcap\n".to_vec()]
}

pub fn metadata(bytes: &[u8]) {
    in_folder(|folder| {
        let folder = folder.join("folder");
        let bag = folder.join("good.mcap");
        if !bag.exists() {
            fs::create_dir_all(&folder).unwrap();
            write(&bag, 1, BagWriterOptions::default());
        }
        fs::write(folder.join("metadata.yaml"), bytes).unwrap();
        read_bag(&folder);
    });
}

type Decode = fn(&[u8]) -> Result<RosMessage, String>;

/// What topics carry, in bags and live.
const DECODERS: [(&str, Decode); 12] = [
    ("/camera/image/compressed", |data| from_cdr(data).map(RosMessage::CompressedImage)),
    ("/camera/image", |data| from_cdr(data).map(RosMessage::Image)),
    ("/camera/camera_info", |data| from_cdr(data).map(RosMessage::CameraInfo)),
    ("/odom", |data| from_cdr(data).map(RosMessage::Odometry)),
    ("/tf", |data| from_cdr(data).map(RosMessage::Tf)),
    ("/tf_static", |data| from_cdr(data).map(RosMessage::TfStatic)),
    ("/foot_contact", |data| from_cdr(data).map(RosMessage::FootContact)),
    ("/foot_pressure", |data| from_cdr(data).map(RosMessage::FootPressure)),
    ("/joint_states", |data| from_cdr(data).map(RosMessage::JointStates)),
    ("/robot_description", |data| from_cdr(data).map(RosMessage::RobotDescription)),
    ("/ground_truth", |data| from_cdr(data).map(RosMessage::GroundTruth)),
    ("/imu/data", |data| from_cdr(data).map(RosMessage::Imu)),
];

/// Messages one after the other: number of the type, length as 16 bits, and the bytes of the message.
pub fn message_seeds() -> Vec<Vec<u8>> {
    [ImageEncoding::Raw, ImageEncoding::Png]
        .map(|encoding| in_folder(|folder| seed_of(folder, encoding)))
        .into()
}

fn seed_of(folder: &Path, image_encoding: ImageEncoding) -> Vec<u8> {
    let path = folder.join("messages.mcap");
    write(&path, 2, BagWriterOptions { image_encoding, ..BagWriterOptions::default() });
    let bytes = fs::read(&path).unwrap();
    let mut seed = Vec::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap().name.clone();
        let number = match (schema.as_str(), message.channel.topic.as_str()) {
            ("sensor_msgs/msg/CompressedImage", _) => 0,
            ("sensor_msgs/msg/Image", _) => 1,
            ("sensor_msgs/msg/CameraInfo", _) => 2,
            ("nav_msgs/msg/Odometry", _) => 3,
            ("tf2_msgs/msg/TFMessage", "/tf") => 4,
            ("tf2_msgs/msg/TFMessage", _) => 5,
            ("std_msgs/msg/Bool", _) => 6,
            ("std_msgs/msg/Float64MultiArray", _) => 7,
            ("sensor_msgs/msg/JointState", _) => 8,
            ("std_msgs/msg/String", _) => 9,
            _ => 10,
        };
        append(&mut seed, number, &message.data);
    }
    let header = messages::Header::new(frame(1).frame.at, "");
    let states = messages::JointState {
        header,
        name: vec!["neck".into(), "left".into()],
        position: vec![0.1, 0.02],
        ..messages::JointState::default()
    };
    append(&mut seed, 8, &to_cdr(&states).unwrap());
    append(
        &mut seed,
        11,
        &to_cdr(&messages::Imu { header: states.header.clone(), ..messages::Imu::default() }).unwrap(),
    );
    append(&mut seed, 9, &to_cdr(&messages::StringMessage { data: ROBOT.into() }).unwrap());
    append(&mut seed, 8, &to_cdr(&states).unwrap());
    seed
}

fn append(seed: &mut Vec<u8>, number: u8, data: &[u8]) {
    seed.push(number);
    seed.extend(u16::try_from(data.len()).unwrap().to_le_bytes());
    seed.extend_from_slice(data);
}

/// As live topics do it: decodes, joins by time, and decodes the images of the frames.
pub fn messages(mut bytes: &[u8]) {
    let all = ExpectedInputs {
        has_odometry: true,
        has_imu: false,
        has_foot_contact: false,
        has_foot_pressure: true,
        has_truth: true,
    };
    let mut synchronizer = Synchronizer::new(&BagTopics::default(), all);
    let mut rejects = Vec::new();
    let mut sent_at = Timestamp::from_nanos(1_700_000_000_000_000_000);
    while let [number, low, high, rest @ ..] = bytes {
        let length = usize::from(u16::from_le_bytes([*low, *high])).min(rest.len());
        let (data, rest) = rest.split_at(length);
        bytes = rest;
        let (_, decode) = DECODERS[usize::from(*number) % DECODERS.len()];
        if let Some(sensed) = decode(data).ok().and_then(|message| message.sensed(sent_at, &mut rejects)) {
            if let SensorMessage::Image(image) = &sensed {
                let _ = image.decode();
            }
            synchronizer.push(sensed);
        }
        // Diagnostics come from others too.
        let _ = from_cdr::<messages::DiagnosticArray>(data);
        sent_at = sent_at + 0.01;
        while let Some(SyncOutcome::Frame(_)) = synchronizer.pop() {}
    }
    synchronizer.finish();
    while let Some(SyncOutcome::Frame(_)) = synchronizer.pop() {}
}
