//! `visloc localize`.

use clap::Args;
use visloc_locate::FeatureChoice;

use super::{
    BroadcastArgs, CorrectionArgs, InputName, InputPath, JsonArg, OutputFile, OutputFolder, OutputRecording,
    OverwriteArg, RangeArgs, SeedArg, SourceArgs, StartArg, ThreadsArg,
    named::named,
    number::{seconds, whole},
};

/// Arguments of `visloc localize`.
#[derive(Debug, Args)]
#[command(
    long_about = "Finds the robot on a map: in a recording (a bag of ROS 2, .mcap, .db3 or a folder, or of ROS 1), on live ROS 2 topics, in a \
                  video, at a webcam, in a simulation; `visloc sources` lists all. Needed are images, their \
                  calibration and the pose of the camera on the robot (/tf, or --camera-height and --camera-tilt). Odometry \
                  and foot sensors are used if they are there. If the source has the truth, the result is compared with it; \
                  the algorithms never see it.\n\n\
                  What is damaged is left out and counted. If a bag or video is cut off, everything until there \
                  is written and the exit code is 1. Live sources go on until Ctrl-C; of images that come while others are \
                  worked on, the newest is used.",
    after_long_help = "Examples:\n  \
                       visloc localize recording.mcap --map robocup-spl-2010\n  \
                       visloc localize recording.mcap --map my-field.toml --algorithm mce --trajectory robot.tum\n  \
                       visloc localize recording.mcap --map my-field.toml --image-topic /eye/image_raw --base-frame base_link\n  \
                       visloc localize sim:kidnaps --plots out/kidnaps\n  \
                       visloc localize ros2:/camera/image_raw --map my-field.toml\n  \
                       visloc localize ros2:/camera/image_raw --map my-field.toml --team ours --number 3\n  \
                       visloc localize clip.mp4 --map my-field.toml --camera camera.toml --camera-height 0.5 --camera-tilt 15\n  \
                       visloc localize sim:tour-2024 --start half:positive\n  \
                       visloc localize game.mcap --map my-field.toml --robot robot.toml --robot-out robot-new.toml\n  \
                       visloc localize clip.mp4 --camera camera.toml --map room.vmap --trajectory camera.tum\n\n\
                       Parameters: visloc config show evolutionary > mine.toml, edit, then --config mine.toml"
)]
pub struct LocalizeArgs {
    /// Bag (.mcap, .db3, folder, or .bag of ROS 1), sim:SCENARIO, ros2:TOPIC, video, v4l2:DEVICE, ... (see: visloc sources)
    #[arg(value_name = "SOURCE")]
    pub source: InputName,
    /// Built-in map, TOML file, or a map of visloc slam (.vmap); may be left out with sim:SCENARIO
    #[arg(long, value_name = "NAME|FILE")]
    pub map: Option<InputName>,
    /// Name of the algorithm (see: visloc algorithms)
    #[arg(long, value_name = "NAME", default_value = "evolutionary")]
    pub algorithm: String,
    /// Parameters of the algorithm, TOML; names only what differs from the defaults
    #[arg(long, value_name = "FILE")]
    pub config: Option<InputPath>,
    /// Parameters of image analysis, observation model and lift detector, TOML
    #[arg(long, value_name = "FILE")]
    pub pipeline: Option<InputPath>,
    /// One parameter of the algorithm over --config, or of --pipeline as pipeline.KEY; can be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// What poses are computed from [default: rich, or what --pipeline says]
    #[arg(long, value_parser = named(FEATURES))]
    pub features: Option<FeatureChoice>,
    /// What is known about the start: half:negative or half:positive (x), side-lines or side-lines:negative or
    /// side-lines:positive, or pose:X,Y,HEADING in meters and degrees (a fourth number is the spread in meters; several
    /// poses can be given)
    #[arg(long, value_name = "WHAT")]
    pub start: Vec<StartArg>,
    /// Take the motion between images from the ground in them, in place of odometry: for robots that have none, on carpets and other ground
    /// with texture
    #[arg(long, conflicts_with = "odometry_topic")]
    pub visual_odometry: bool,
    #[command(flatten)]
    pub corrections: CorrectionArgs,
    /// Write the corrections to this file at the end, for the next run's --robot: with the constant error of the camera's direction that this
    /// run has shown
    #[arg(long, value_name = "FILE")]
    pub robot_out: Option<OutputFile>,
    /// Options and parameters as ROS 2 programs take them, YAML (docs/ros2.md#parameters); what is typed wins
    #[arg(long, value_name = "FILE")]
    pub params_file: Option<InputPath>,
    /// Publish pose, path, tf, hypotheses and reliability as ROS 2 topics [default for ros2: sources]
    #[arg(long)]
    pub publish_ros: bool,
    /// Publish nothing
    #[arg(long, conflicts_with = "publish_ros")]
    pub no_publish_ros: bool,
    /// Publish the map as well, for Nav2: /map, nav_msgs/OccupancyGrid; not beside a map server. A .vmap needs meters and z up
    #[arg(long, conflicts_with = "no_publish_ros")]
    pub publish_map: bool,
    /// Let this robot and others of its team help each other over ROS 2 (docs/teams.md); needs --number
    #[arg(long, value_name = "NAME", requires = "number", conflicts_with = "no_publish_ros")]
    pub team: Option<String>,
    /// The robot's number, which no other one of its team has
    #[arg(long, value_name = "N", requires = "team", value_parser = whole::<u8>(0..))]
    pub number: Option<u8>,
    /// Write the frames with pose, path, tf and reliability beside them as a ROS 2 bag
    #[arg(long, value_name = "BAG")]
    pub bag_out: Option<OutputRecording>,
    /// Write the pose of every frame to this file, TUM format
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<OutputFile>,
    /// Write every frame's pose, reliability and uncertainty to this file, CSV
    #[arg(long, value_name = "FILE")]
    pub estimates: Option<OutputFile>,
    /// Draw pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub plots: Option<OutputFolder>,
    /// The image shown in the picture of the analysis, seconds after the first [default: the most telling one]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "plots")]
    pub picture_at: Option<f64>,
    /// Stop after this many frames
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub overwrite: OverwriteArg,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub threads: ThreadsArg,
    #[command(flatten)]
    pub topics: TopicArgs,
    #[command(flatten)]
    pub range: RangeArgs,
    #[command(flatten)]
    pub options: SourceArgs,
    #[command(flatten)]
    pub broadcast: BroadcastArgs,
}

/// What poses are computed from.
const FEATURES: &[(&str, FeatureChoice, &str)] = &[
    ("pixels", FeatureChoice::Pixels, "Twenty pixels an image, as in the documents"),
    ("rich", FeatureChoice::Rich, "All borders in view refine what the algorithm finds"),
];

/// Names of topics and frames, in a bag or live.
#[derive(Debug, Clone, Default, PartialEq, Eq, Args)]
#[command(next_help_heading = "Topics")]
pub struct TopicArgs {
    /// Names of all topics and frames, TOML (see: visloc config show topics); those of tf and of the feet can be set only
    /// here
    #[arg(long, value_name = "FILE")]
    pub topics: Option<InputPath>,
    /// Topic of the images; given several times, those of a robot's cameras, each with the calibration beside it (localize, bags)
    #[arg(long, value_name = "TOPIC")]
    pub image_topic: Vec<String>,
    /// Topic of the calibration
    #[arg(long, value_name = "TOPIC")]
    pub camera_info_topic: Option<String>,
    /// Topic of the odometry; "" for none
    #[arg(long, value_name = "TOPIC")]
    pub odometry_topic: Option<String>,
    /// Topic of the truth; "" for none
    #[arg(long, value_name = "TOPIC")]
    pub truth_topic: Option<String>,
    /// Frame of the robot on the ground: x forward, y left, z up
    #[arg(long, value_name = "FRAME")]
    pub base_frame: Option<String>,
    /// Optical frame of the camera [default: the one in the images' headers]
    #[arg(long, value_name = "FRAME")]
    pub camera_frame: Option<String>,
}
