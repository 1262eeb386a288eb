//! Options of everything that frames come from.

use clap::{Args, ValueEnum};
use visloc_io::{
    bag::ImageQos,
    sequence::{Bound, SequenceRange},
    sources::{FORWARD_M, HEIGHTS_M, PATIENCES_SECS, RATES_HZ},
};

use super::{
    InputName, InputPath, OutputFolder, OutputRecording, OverwriteArg,
    named::named,
    number::{degrees, whole, within},
};

/// How a source is opened.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Source")]
pub struct SourceArgs {
    /// Calibration of the camera, over what the source itself says: TOML, CameraInfo, OpenCV, Kalibr (docs/own-camera.md)
    #[arg(long, value_name = "FILE", visible_alias = "calibration")]
    pub camera: Option<InputPath>,
    /// Where the camera is on the robot, over or in place of tf: height above the ground, meters
    #[arg(long, value_name = "M", value_parser = within(HEIGHTS_M.0, HEIGHTS_M.1))]
    pub camera_height: Option<f64>,
    /// How far the camera looks down, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, value_parser = degrees, requires = "camera_height")]
    pub camera_tilt: f64,
    /// How far it is turned to the left, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, value_parser = degrees, requires = "camera_height")]
    pub camera_pan: f64,
    /// How far it is rolled about its axis, clockwise as seen from behind, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, value_parser = degrees, requires = "camera_height")]
    pub camera_roll: f64,
    /// How far ahead of the robot's middle it is, meters
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_parser = within(FORWARD_M.0, FORWARD_M.1),
        requires = "camera_height"
    )]
    pub camera_forward: f64,
    /// Description of the robot (URDF), over /robot_description: with /joint_states it says where the camera is (docs/own-robot.md)
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<InputPath>,
    #[command(flatten)]
    pub pictures: PictureArgs,
}

/// How pictures are taken from a source, whatever they are for.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Source")]
pub struct PictureArgs {
    /// Images a second: of a folder without times, of a video in place of its own, and what a camera is asked for
    #[arg(long, value_name = "HZ", value_parser = within(RATES_HZ.0, RATES_HZ.1))]
    pub fps: Option<f64>,
    /// End a live source when nothing came for this long, seconds [default: wait until Ctrl-C]
    #[arg(long, value_name = "SECONDS", value_parser = within(PATIENCES_SECS.0, PATIENCES_SECS.1))]
    pub patience: Option<f64>,
    /// The program that decodes videos and cameras [default: ffmpeg]
    #[arg(long, value_name = "PROGRAM")]
    pub ffmpeg: Option<InputPath>,
    /// How images of live ROS 2 topics are asked for [default: best-effort]
    #[arg(long, value_parser = named(IMAGE_QOS), value_name = "QOS")]
    pub image_qos: Option<ImageQos>,
    /// Domain of live ROS 2 topics [default: ROS_DOMAIN_ID, or 0]
    #[arg(long, value_name = "ID", value_parser = whole::<u16>(0..=232))]
    pub ros_domain: Option<u16>,
}

/// Which part of a source is used.
#[derive(Debug, Clone, Copy, PartialEq, Args)]
#[command(next_help_heading = "Source")]
pub struct RangeArgs {
    /// First image: a number from 0, or seconds after the first image of the source with an s (4.5s)
    #[arg(long, value_name = "N|SECS", default_value = "0")]
    pub from: Bound,
    /// One past the last image, as --from [default: all]
    #[arg(long, value_name = "N|SECS")]
    pub until: Option<Bound>,
}

impl RangeArgs {
    /// The part of the source.
    pub fn range(&self) -> SequenceRange {
        SequenceRange { start: self.from, end: self.until, ..SequenceRange::default() }
    }
}

/// How a source is opened from which nothing but pictures is wanted.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Source")]
pub struct PictureSourceArgs {
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Topic of the images, of a bag with several
    #[arg(long, value_name = "TOPIC")]
    pub image_topic: Option<String>,
}

/// How images of live topics are asked for.
const IMAGE_QOS: &[(&str, ImageQos, &str)] = &[
    ("best-effort", ImageQos::BestEffort, "What is lost is lost; every publisher is heard"),
    ("reliable", ImageQos::Reliable, "What is lost is sent again; best-effort publishers are not heard"),
];

/// Arguments of `visloc sources`.
#[derive(Debug, Args)]
#[command(
    long_about = "Lists what frames can come from: for localize, slam, record and the other commands. Says which kinds work \
                  here, and why others do not.",
    after_long_help = "Examples:\n  visloc sources\n  visloc sources --json"
)]
pub struct SourcesArgs {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// The program that decodes videos and cameras
    #[arg(long, value_name = "PROGRAM", default_value = "ffmpeg")]
    pub ffmpeg: InputPath,
}

/// Arguments of `visloc record`.
#[derive(Debug, Args)]
#[command(
    long_about = "Writes what a source delivers as a ROS 2 bag: images and calibration, and of a robot also kinematics, odometry, \
                  feet and truth. A live source is recorded until Ctrl-C, --frames or --patience.\n\n\
                  A bag (.mcap, .db3, .bag of ROS 1) is converted: all its messages, or those of a part, are copied, unless an option of \
                  images, camera, mount or topics asks for something else: images are written anew then.\n\n\
                  A path that ends in .mcap becomes one file, any other a folder with metadata.yaml.",
    after_long_help = "Examples:\n  \
                       visloc record ros2:/camera/image_raw --out out/run.mcap\n  \
                       visloc record v4l2:/dev/video0 --camera camera.toml --out out/webcam.mcap --frames 300\n  \
                       visloc record clip.mp4 --out out/clip.mcap\n  \
                       visloc record old.bag --out out/old.mcap\n  \
                       visloc record sim:office --out out/office.mcap --frames 100"
)]
pub struct RecordArgs {
    /// What to record (see: visloc sources)
    #[arg(value_name = "SOURCE")]
    pub source: InputName,
    /// The bag: FILE.mcap or a folder
    #[arg(long, value_name = "BAG")]
    pub out: OutputRecording,
    #[command(flatten)]
    pub overwrite: OverwriteArg,
    /// How images are stored [default: jpeg; those of a bag that is copied stay as they are]
    #[arg(long, value_enum)]
    pub images: Option<ImageFormat>,
    /// Images and calibration only, of sources that have more
    #[arg(long)]
    pub images_only: bool,
    /// Stop after this many images
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub seed: super::SeedArg,
    #[command(flatten)]
    pub threads: super::ThreadsArg,
    #[command(flatten)]
    pub range: RangeArgs,
    #[command(flatten)]
    pub options: SourceArgs,
    #[command(flatten)]
    pub topics: super::TopicArgs,
}

/// Arguments of `visloc extract`.
#[derive(Debug, Args)]
#[command(
    long_about = "Writes the images of a source into a folder: rgb/SECONDS.jpg or .png, their list rgb.txt, and camera.yaml if the \
                  calibration is known. visloc slam and others read such a folder (the layout of TUM).",
    after_long_help = "Examples:\n  \
                       visloc extract recording.mcap --out out/images\n  \
                       visloc extract old.bag --image-topic /eye/image_raw --out out/images --every 10\n  \
                       visloc extract clip.mp4 --camera camera.toml --out out/clip --frames 100\n  \
                       visloc slam out/clip"
)]
pub struct ExtractArgs {
    /// What to take the images from (see: visloc sources)
    #[arg(value_name = "SOURCE")]
    pub source: InputName,
    /// The folder, new or empty
    #[arg(long, value_name = "DIR")]
    pub out: OutputFolder,
    /// How images are stored
    #[arg(long, value_enum, default_value_t = ExtractFormat::Original)]
    pub format: ExtractFormat,
    /// Take one image of so many
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..))]
    pub every: u32,
    /// Stop after this many images
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub seed: super::SeedArg,
    #[command(flatten)]
    pub threads: super::ThreadsArg,
    #[command(flatten)]
    pub range: RangeArgs,
    #[command(flatten)]
    pub options: SourceArgs,
    #[command(flatten)]
    pub topics: super::TopicArgs,
}

/// How extracted images are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExtractFormat {
    /// The JPEG and PNG files of the source as they are; others as PNG
    Original,
    /// PNG: every pixel exact
    Png,
    /// JPEG of quality 90
    Jpeg,
}

/// How images are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ImageFormat {
    /// JPEG of quality 90
    Jpeg,
    /// PNG: every pixel exact
    Png,
    /// Rows of pixels, `sensor_msgs/msg/Image`
    Raw,
}
