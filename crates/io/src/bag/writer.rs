//! Writes frames as a recording.

use std::{
    io,
    path::{Path, PathBuf},
};

#[cfg(feature = "compression")]
use mcap::Compression;
use mcap::WriteOptions;
use serde::Serialize;
use visloc_core::{
    Frame, GrayImage, GroundContact, Picture, RgbImage, SourceFrame, Timestamp, Truth, files,
    geom::{Camera, PlanarPose},
};

use crate::{
    bag::{
        BagError, BagMessage, BagTopics, ResultMessage, TopicRole,
        channels::ChannelWriter,
        messages::{self, Header, Pose},
        metadata::metadata_yaml,
    },
    image_codec,
    ros_lens::ros_distortion,
};

/// How pictures are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageEncoding {
    /// As JPEG with a quality from 1 to 100.
    Jpeg {
        /// 1 to 100.
        quality: u8,
    },
    /// As PNG: every pixel exact.
    Png,
    /// As rows of pixels, `sensor_msgs/msg/Image` in rgb8.
    Raw,
}

/// How the parts of the file are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChunkCompression {
    /// Not at all, best for pictures that are compressed already.
    None,
    /// Zstandard.
    #[cfg(feature = "compression")]
    Zstd,
    /// LZ4.
    #[cfg(feature = "compression")]
    Lz4,
}

visloc_core::with_defaults! {
    /// Choices for [`BagWriter`].
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct BagWriterOptions {
        /// How pictures are stored; JPEG of quality 90 unless set.
        pub image_encoding: ImageEncoding = ImageEncoding::Jpeg { quality: 90 },
        /// How the parts of the file are compressed; not at all unless set.
        pub chunk_compression: ChunkCompression = ChunkCompression::None,
        /// Whether messages are gathered in chunks, as usual. Without them each stands at its own place in the file.
        pub has_chunks: bool = true,
    }
}

/// Writes a ROS 2 bag that any MCAP tool can decode.
pub struct BagWriter {
    folder: Option<PathBuf>,
    topics: BagTopics,
    options: BagWriterOptions,
    channels: ChannelWriter,
    /// Stamp of the last frame, whose further cameras have the rest in common with it.
    last_at: Option<Timestamp>,
}

visloc_core::debug_shows!([] BagWriter { folder, topics, last_at });

impl BagWriter {
    /// Starts a recording. A path that ends in `.mcap` becomes that file, any other a folder with `metadata.yaml`.
    /// It is made, and a file that is there replaced, when the first message comes.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub fn create(path: impl AsRef<Path>, topics: BagTopics) -> Result<Self, BagError> {
        Self::create_with(path, topics, BagWriterOptions::default())
    }

    /// As [`BagWriter::create`], with choices.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub fn create_with(
        path: impl AsRef<Path>,
        topics: BagTopics,
        options: BagWriterOptions,
    ) -> Result<Self, BagError> {
        let path = path.as_ref();
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap")) {
            return Self::create_file(path, topics, options);
        }
        if path.exists() && !path.is_dir() {
            let source = io::Error::new(
                io::ErrorKind::NotADirectory,
                "expected a name that ends in .mcap for a file, or a folder; found neither",
            );
            return Err(BagError::Io { path: path.to_path_buf(), action: "write a recording there", source });
        }
        let name = path.file_name().map_or_else(|| "bag".into(), |name| name.to_string_lossy());
        let writer = Self::create_file(&path.join(format!("{name}_0.mcap")), topics, options)?;
        Ok(Self { folder: Some(path.to_path_buf()), ..writer })
    }

    /// As [`BagWriter::create_with`], one file whatever its name ends in.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub fn create_file(path: &Path, topics: BagTopics, options: BagWriterOptions) -> Result<Self, BagError> {
        files::try_file(path).map_err(|source| BagError::Io {
            path: path.to_path_buf(),
            action: "create it",
            source,
        })?;
        let compression = match options.chunk_compression {
            ChunkCompression::None => None,
            #[cfg(feature = "compression")]
            ChunkCompression::Zstd => Some(Compression::Zstd),
            #[cfg(feature = "compression")]
            ChunkCompression::Lz4 => Some(Compression::Lz4),
        };
        let write_options = WriteOptions::new()
            .profile("ros2")
            .library("visloc")
            .compression(compression)
            .use_chunks(options.has_chunks);
        let channels = ChannelWriter::new(path.to_path_buf(), write_options);
        Ok(Self { folder: None, topics, options, channels, last_at: None })
    }

    /// Appends a frame: one message on each topic for which it has a value and which has a name.
    ///
    /// # Errors
    /// If the image cannot be encoded or the file not be written.
    pub fn write(&mut self, source_frame: &SourceFrame) -> Result<(), BagError> {
        self.write_frame(&source_frame.frame, source_frame.truth.as_ref())
    }

    /// As [`BagWriter::write`], in parts.
    ///
    /// # Errors
    /// If the image cannot be encoded or the file not be written.
    pub fn write_frame(&mut self, frame: &Frame, truth: Option<&Truth>) -> Result<(), BagError> {
        let at = frame.at;
        let is_first_of_moment = self.last_at.replace(at) != Some(at);
        if is_first_of_moment && let Some(truth) = truth {
            self.send(TopicRole::GroundTruth, at, &truth_message(at, truth))?;
        }
        if is_first_of_moment && let Some(odometry) = &frame.odometry {
            self.send(TopicRole::Odometry, at, &odometry_message(at, odometry, &self.topics.base_frame))?;
        }
        let (image, camera_info, camera_frame) = self.topics.of_camera(frame.camera_index);
        self.send(TopicRole::Tf, at, &tf_message(frame, &self.topics.base_frame, &camera_frame))?;
        match frame.ground_contact.filter(|_| is_first_of_moment) {
            Some(GroundContact::Contact(data)) => {
                self.send(TopicRole::FootContact, at, &messages::Bool { data })?;
            }
            Some(GroundContact::Pressure(forces)) => {
                self.send(TopicRole::FootPressure, at, &pressure_message(&forces))?;
            }
            None => {}
        }
        let message = camera_info_message(at, &frame.camera, &camera_frame);
        self.send_on(&camera_info, TopicRole::CameraInfo, at, &message)?;
        self.send_image(at, &frame.image, (&image, &camera_frame))?;
        self.channels.end_moment(at)
    }

    /// Appends a picture without a robot, with its calibration if that is known.
    ///
    /// # Errors
    /// If the image cannot be encoded or the file not be written.
    pub fn write_picture(&mut self, picture: &Picture, camera: Option<&Camera>) -> Result<(), BagError> {
        let (image, _, camera_frame) = self.topics.of_camera(0);
        if let Some(camera) = camera {
            let message = camera_info_message(picture.at, camera, &camera_frame);
            self.send(TopicRole::CameraInfo, picture.at, &message)?;
        }
        self.send_image(picture.at, &picture.image, (&image, &camera_frame))?;
        self.channels.end_moment(picture.at)
    }

    /// Appends a gray picture with its calibration, as PNG whatever the encoding of others.
    ///
    /// # Errors
    /// If the image cannot be encoded or the file not be written.
    pub fn write_gray(&mut self, at: Timestamp, image: &GrayImage, camera: &Camera) -> Result<(), BagError> {
        let camera_frame = self.topics.of_camera(0).2;
        self.send(TopicRole::CameraInfo, at, &camera_info_message(at, camera, &camera_frame))?;
        let data = image_codec::encode_gray_png(image);
        let data = data.map_err(|error| self.channels.encode_error(at, error.to_string()))?;
        let header = Header::new(at, &camera_frame);
        self.send(
            TopicRole::Image,
            at,
            &messages::CompressedImage { header, format: "mono8; png compressed".into(), data },
        )
    }

    /// Appends a message of a result, stamped with the time of its image.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_result(&mut self, at: Timestamp, result: &ResultMessage) -> Result<(), BagError> {
        let channel = (result.topic(), result.type_name());
        match result {
            ResultMessage::Pose(message) => self.channels.send(channel, at, message),
            ResultMessage::Path(message) => self.channels.send(channel, at, message),
            ResultMessage::Transform(message) => self.channels.send(channel, at, message),
            ResultMessage::Hypotheses(message) => self.channels.send(channel, at, message),
            ResultMessage::Reliability(message) => self.channels.send(channel, at, message),
            ResultMessage::Diagnostics(message) => self.channels.send(channel, at, message),
        }
    }

    /// Appends bytes of another kind than messages of ROS, on a topic of their own; `encoding` tells other tools what they are.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_raw(
        &mut self,
        (topic, encoding): (&str, &str),
        at: Timestamp,
        bytes: &[u8],
    ) -> Result<(), BagError> {
        self.channels.send_raw((topic, encoding), at, bytes)
    }

    /// Makes sure that what was written so far can be read if the program is killed, if that was not done for half a second of the
    /// recording. Frames and pictures do so by themselves.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn end_moment(&mut self, at: Timestamp) -> Result<(), BagError> {
        self.channels.end_moment(at)
    }

    /// Appends a message as it stands in another recording: same bytes, times, type and definition.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_copy(&mut self, message: &BagMessage) -> Result<(), BagError> {
        self.channels.copy(message)
    }

    /// Completes the file, and the folder's `metadata.yaml`. Without it the file lacks its index but can be read. Where no message
    /// came, nothing is left.
    ///
    /// # Errors
    /// If the rest cannot be written.
    pub fn finish(mut self) -> Result<(), BagError> {
        let has_file = self.channels.finish()?;
        let Some(folder) = self.folder.as_ref().filter(|_| has_file) else { return Ok(()) };
        let (start_nanos, duration_nanos) = self.channels.span_nanos();
        let topics = self.channels.topics();
        let file_name = self.channels.path().file_name().unwrap_or_default().to_string_lossy();
        let text = metadata_yaml(&file_name, start_nanos, duration_nanos, &topics);
        let path = folder.join("metadata.yaml");
        files::replace(&path, text).map_err(|source| BagError::Io { path, action: "write it", source })
    }

    fn send_image(
        &mut self,
        at: Timestamp,
        image: &RgbImage,
        (topic, camera_frame): (&str, &str),
    ) -> Result<(), BagError> {
        let header = Header::new(at, camera_frame);
        let (encoded, format) = match self.options.image_encoding {
            ImageEncoding::Jpeg { quality } => {
                (image_codec::encode_jpeg(image, quality), "rgb8; jpeg compressed")
            }
            ImageEncoding::Png => (image_codec::encode_png(image), "rgb8; png compressed"),
            ImageEncoding::Raw => {
                let message = messages::Image {
                    header,
                    height: image.height(),
                    width: image.width(),
                    encoding: "rgb8".into(),
                    is_bigendian: 0,
                    step: image.width() * 3,
                    data: image.data().to_vec(),
                };
                return self.send_on(topic, TopicRole::Image, at, &message);
            }
        };
        let data = encoded.map_err(|error| self.channels.encode_error(at, error.to_string()))?;
        let message = messages::CompressedImage { header, format: format.into(), data };
        self.send_on(topic, TopicRole::Image, at, &message)
    }

    fn send<T: Serialize>(&mut self, role: TopicRole, at: Timestamp, message: &T) -> Result<(), BagError> {
        let topic = self.topics.name(role).to_owned();
        self.send_on(&topic, role, at, message)
    }

    fn send_on<T: Serialize>(
        &mut self,
        topic: &str,
        role: TopicRole,
        at: Timestamp,
        message: &T,
    ) -> Result<(), BagError> {
        let type_name = match (role, self.options.image_encoding) {
            (TopicRole::Image, ImageEncoding::Raw) => "sensor_msgs/msg/Image",
            _ => role.type_names()[0],
        };
        self.channels.send((topic, type_name), at, message)
    }
}

fn truth_message(at: Timestamp, truth: &Truth) -> messages::PoseStamped {
    let pose = Pose::planar(&truth.world_from_robot, truth.height_m);
    messages::PoseStamped { header: Header::new(at, "map"), pose }
}

fn odometry_message(at: Timestamp, odometry: &PlanarPose, base_frame: &str) -> messages::Odometry {
    messages::Odometry {
        header: Header::new(at, "odom"),
        child_frame_id: base_frame.into(),
        pose: messages::PoseWithCovariance { pose: Pose::planar(odometry, 0.0), ..Default::default() },
        twist: messages::TwistWithCovariance::default(),
    }
}

fn tf_message(frame: &Frame, base_frame: &str, camera_frame: &str) -> messages::TfMessage {
    let transform = messages::TransformStamped {
        header: Header::new(frame.at, base_frame),
        child_frame_id: camera_frame.into(),
        transform: Pose::rigid(&frame.robot_from_camera),
    };
    messages::TfMessage { transforms: vec![transform] }
}

fn pressure_message(forces: &[f64; 8]) -> messages::Float64MultiArray {
    messages::Float64MultiArray { data: forces.to_vec(), ..Default::default() }
}

/// The calibration of a camera as a message.
pub fn camera_info_message(at: Timestamp, camera: &Camera, camera_frame: &str) -> messages::CameraInfo {
    let ((width, height), (fx, fy), (cx, cy)) = (camera.size_px(), camera.focal_px(), camera.center_px());
    let (model, d) = ros_distortion(camera.distortion());
    messages::CameraInfo {
        header: Header::new(at, camera_frame),
        height,
        width,
        distortion_model: model.into(),
        d,
        k: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..Default::default()
    }
}
