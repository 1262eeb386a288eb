//! Writes frames as a recording.

use std::{
    fs::{self, File},
    io::BufWriter,
    path::{Path, PathBuf},
};

use mcap::{Compression, WriteOptions, Writer, records::MessageHeader};
use serde::Serialize;
use visloc_base::{Frame, GroundContact, SourceFrame, Timestamp, Truth};
use visloc_geom::{PlanarPose, Rigid3};

use crate::{
    bag::{
        BagError, BagTopics, TopicInfo, TopicRole,
        messages::{self, Header, Pose, Quaternion, Vector3, to_cdr},
        metadata::metadata_yaml,
        schemas,
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
    Zstd,
    /// LZ4.
    Lz4,
}

/// Choices for [`BagWriter`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BagWriterOptions {
    /// How pictures are stored; JPEG of quality 90 unless set.
    pub image_encoding: ImageEncoding,
    /// How the parts of the file are compressed; not at all unless set.
    pub chunk_compression: ChunkCompression,
}

impl Default for BagWriterOptions {
    fn default() -> Self {
        Self {
            image_encoding: ImageEncoding::Jpeg { quality: 90 },
            chunk_compression: ChunkCompression::None,
        }
    }
}

/// Name of the camera's frame where the topics do not set one.
const CAMERA_FRAME: &str = "camera_optical";

/// Writes a ROS 2 bag that any MCAP tool can decode.
pub struct BagWriter {
    path: PathBuf,
    folder: Option<PathBuf>,
    topics: BagTopics,
    options: BagWriterOptions,
    writer: Writer<BufWriter<File>>,
    channels: Vec<(TopicRole, u16, TopicInfo)>,
    first_at: Option<Timestamp>,
    last_at: Timestamp,
    sequence: u32,
}

impl BagWriter {
    /// Starts a recording. A path that ends in `.mcap` becomes that file, any other a folder with `metadata.yaml`.
    /// A file that is there is replaced.
    ///
    /// # Errors
    /// If the file or folder cannot be made.
    pub fn create(path: impl AsRef<Path>, topics: BagTopics) -> Result<Self, BagError> {
        Self::create_with(path, topics, BagWriterOptions::default())
    }

    /// As [`BagWriter::create`], with choices.
    ///
    /// # Errors
    /// If the file or folder cannot be made.
    pub fn create_with(
        path: impl AsRef<Path>,
        topics: BagTopics,
        options: BagWriterOptions,
    ) -> Result<Self, BagError> {
        let path = path.as_ref();
        let is_file = path.extension().is_some_and(|extension| extension == "mcap");
        let (path, folder) = if is_file {
            (path.to_path_buf(), None)
        } else {
            fs::create_dir_all(path).map_err(|source| BagError::Io {
                path: path.to_path_buf(),
                action: "make the folder",
                source,
            })?;
            let name = path.file_name().map_or_else(|| "bag".into(), |name| name.to_string_lossy());
            (path.join(format!("{name}_0.mcap")), Some(path.to_path_buf()))
        };
        let file = File::create(&path).map_err(|source| BagError::Io {
            path: path.clone(),
            action: "create it",
            source,
        })?;
        let compression = match options.chunk_compression {
            ChunkCompression::None => None,
            ChunkCompression::Zstd => Some(Compression::Zstd),
            ChunkCompression::Lz4 => Some(Compression::Lz4),
        };
        let write_options = WriteOptions::new().profile("ros2").library("visloc").compression(compression);
        let writer =
            write_options.create(BufWriter::new(file)).map_err(|error| write_error(&path, &error))?;
        Ok(Self {
            path,
            folder,
            topics,
            options,
            writer,
            channels: Vec::new(),
            first_at: None,
            last_at: Timestamp::default(),
            sequence: 0,
        })
    }

    /// Appends a frame: one message on each topic for which it has a value and which has a name.
    ///
    /// # Errors
    /// If the image cannot be encoded or the file not be written.
    pub fn write(&mut self, source_frame: &SourceFrame) -> Result<(), BagError> {
        let frame = &source_frame.frame;
        let at = frame.at;
        self.first_at.get_or_insert(at);
        self.last_at = at;
        if let Some(truth) = &source_frame.truth {
            self.send(TopicRole::GroundTruth, at, &truth_message(at, truth))?;
        }
        if let Some(odometry) = &frame.odometry {
            self.send(TopicRole::Odometry, at, &odometry_message(at, odometry, &self.topics.base_frame))?;
        }
        let camera_frame = self.topics.camera_frame.clone().unwrap_or_else(|| CAMERA_FRAME.into());
        self.send(TopicRole::Tf, at, &tf_message(frame, &self.topics.base_frame, &camera_frame))?;
        match frame.ground_contact {
            Some(GroundContact::Contact(data)) => {
                self.send(TopicRole::FootContact, at, &messages::Bool { data })?;
            }
            Some(GroundContact::Pressure(forces)) => {
                self.send(TopicRole::FootPressure, at, &pressure_message(&forces))?;
            }
            None => {}
        }
        self.send(TopicRole::CameraInfo, at, &camera_info_message(frame, &camera_frame))?;
        self.send_image(frame, &camera_frame)?;
        self.sequence = self.sequence.wrapping_add(1);
        Ok(())
    }

    /// Completes the file, and the folder's `metadata.yaml`. Without it the file lacks its index but can be read.
    ///
    /// # Errors
    /// If the rest cannot be written.
    pub fn finish(mut self) -> Result<(), BagError> {
        self.writer.finish().map_err(|error| write_error(&self.path, &error))?;
        let Some(folder) = &self.folder else { return Ok(()) };
        let start_nanos = self.first_at.unwrap_or_default().nanos();
        let duration_nanos = self.last_at.nanos() - start_nanos;
        let topics: Vec<_> = self.channels.iter().map(|(_, _, info)| info.clone()).collect();
        let file_name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let text = metadata_yaml(&file_name, start_nanos, duration_nanos, &topics);
        let path = folder.join("metadata.yaml");
        fs::write(&path, text).map_err(|source| BagError::Io { path, action: "write it", source })
    }

    fn send_image(&mut self, frame: &Frame, camera_frame: &str) -> Result<(), BagError> {
        let header = Header::new(frame.at, camera_frame);
        let image = &frame.image;
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
                return self.send(TopicRole::Image, frame.at, &message);
            }
        };
        let data = encoded.map_err(|error| self.encode_error(frame.at, error.to_string()))?;
        let message = messages::CompressedImage { header, format: format.into(), data };
        self.send(TopicRole::Image, frame.at, &message)
    }

    fn send<T: Serialize>(&mut self, role: TopicRole, at: Timestamp, message: &T) -> Result<(), BagError> {
        if self.topics.name(role).is_empty() {
            return Ok(());
        }
        let data = to_cdr(message).map_err(|reason| self.encode_error(at, reason))?;
        let channel_id = self.channel(role)?;
        // MCAP counts time from 1970; earlier stamps stay exact in the header of the message.
        let nanos = u64::try_from(at.nanos()).unwrap_or(0);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: nanos, publish_time: nanos };
        self.writer.write_to_known_channel(&header, &data).map_err(|error| write_error(&self.path, &error))
    }

    /// Channel of a role, made when it is first used; counts the message.
    fn channel(&mut self, role: TopicRole) -> Result<u16, BagError> {
        if let Some((_, id, info)) = self.channels.iter_mut().find(|(known, ..)| *known == role) {
            info.num_messages += 1;
            return Ok(*id);
        }
        let type_name = match (role, self.options.image_encoding) {
            (TopicRole::Image, ImageEncoding::Raw) => "sensor_msgs/msg/Image",
            _ => role.type_names()[0],
        };
        let definition = schemas::definition(type_name).unwrap_or_default();
        let topic = self.topics.name(role).to_string();
        let id = self
            .writer
            .add_schema(type_name, "ros2msg", definition.as_bytes())
            .and_then(|schema| {
                let metadata = [("offered_qos_profiles".to_string(), String::new())].into();
                self.writer.add_channel(schema, &topic, "cdr", &metadata)
            })
            .map_err(|error| write_error(&self.path, &error))?;
        let info =
            TopicInfo { topic, type_name: type_name.into(), message_encoding: "cdr".into(), num_messages: 1 };
        self.channels.push((role, id, info));
        Ok(id)
    }

    fn encode_error(&self, at: Timestamp, reason: String) -> BagError {
        BagError::Encode { path: self.path.clone(), at, reason }
    }
}

fn write_error(path: &Path, error: &mcap::McapError) -> BagError {
    BagError::Write { path: path.to_path_buf(), reason: error.to_string() }
}

fn planar_message(pose: &PlanarPose, height_m: f64) -> Pose {
    let (z, w) = (0.5 * pose.yaw_rad).sin_cos();
    Pose {
        position: Vector3 { x: pose.x_m, y: pose.y_m, z: height_m },
        orientation: Quaternion { x: 0.0, y: 0.0, z, w },
    }
}

fn rigid_message<Dst, Src>(pose: &Rigid3<Dst, Src>) -> Pose {
    let (t, [x, y, z, w]) = (pose.translation(), pose.quaternion_xyzw());
    Pose { position: Vector3 { x: t.x, y: t.y, z: t.z }, orientation: Quaternion { x, y, z, w } }
}

fn truth_message(at: Timestamp, truth: &Truth) -> messages::PoseStamped {
    let pose = planar_message(&truth.world_from_robot, truth.height_m);
    messages::PoseStamped { header: Header::new(at, "map"), pose }
}

fn odometry_message(at: Timestamp, odometry: &PlanarPose, base_frame: &str) -> messages::Odometry {
    messages::Odometry {
        header: Header::new(at, "odom"),
        child_frame_id: base_frame.into(),
        pose: messages::PoseWithCovariance { pose: planar_message(odometry, 0.0), ..Default::default() },
        twist: messages::TwistWithCovariance::default(),
    }
}

fn tf_message(frame: &Frame, base_frame: &str, camera_frame: &str) -> messages::TfMessage {
    let transform = messages::TransformStamped {
        header: Header::new(frame.at, base_frame),
        child_frame_id: camera_frame.into(),
        transform: rigid_message(&frame.robot_from_camera),
    };
    messages::TfMessage { transforms: vec![transform] }
}

fn pressure_message(forces: &[f64; 8]) -> messages::Float64MultiArray {
    messages::Float64MultiArray { data: forces.to_vec(), ..Default::default() }
}

fn camera_info_message(frame: &Frame, camera_frame: &str) -> messages::CameraInfo {
    let ((width, height), (fx, fy), (cx, cy)) =
        (frame.camera.size_px(), frame.camera.focal_px(), frame.camera.center_px());
    let (model, d) = ros_distortion(frame.camera.distortion());
    messages::CameraInfo {
        header: Header::new(frame.at, camera_frame),
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
