//! `visloc slam`.

use clap::Args;
use visloc_io::sequence::Bound;
use visloc_slam::Schedule;

use super::{
    BroadcastArgs, InputMap, InputName, InputPath, JsonArg, OutputFile, OutputFolder, OutputMap,
    OverwriteArg, SeedArg, SourceArgs, TopicArgs,
    named::named,
    number::{number, whole},
};

/// Parameters of SLAM.
#[derive(Debug, Clone, Args)]
pub struct SlamParametersArgs {
    /// Parameters to start from: sdvl, orb-sdvl, small (for small computers), or one of the eight configurations of the thesis, config1 to config8
    #[arg(long, value_name = "NAME", default_value = "sdvl")]
    pub preset: String,
    /// Parameters, TOML; names only what differs from the preset
    #[arg(long, value_name = "FILE")]
    pub config: Option<InputPath>,
    /// One parameter, over preset and file; can be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// When tracking and mapping run.
const SCHEDULES: &[(&str, Schedule, &str)] = &[
    (
        "sequential",
        Schedule::Sequential,
        "One after the other; the same seed gives the same result, bit by bit",
    ),
    ("threaded", Schedule::Threaded, "Mapping has a thread of its own and tracking never waits for it"),
];

/// Arguments of `visloc slam`.
#[derive(Debug, Args)]
#[command(
    long_about = "Follows one calibrated camera through a sequence of images without a map, and makes a sparse map of what \
                  it sees. If the sequence has the truth, the result is compared with it.\n\n\
                  SOURCE is the folder of a dataset: TUM RGB-D, ICL-NUIM, EuRoC, Zurich urban MAV, KITTI odometry, or \
                  images with a calibration; the layout is recognized, camera and truth are read from the dataset's own \
                  files (docs/datasets.md). Or a sequence of the simulator: sim:room, sim:hall, sim:walking, \
                  sim:kidnap; a ROS 2 bag; a video or a webcam with --camera; live topics (`visloc sources`).\n\n\
                  One camera knows no scale: lengths are in map units, the median depth at the start is 1, unless the odometry of a \
                  robot tells meters.",
    after_long_help = "Examples:\n  \
                       visloc slam desk --trajectory desk.tum --points desk.ply\n  \
                       visloc slam desk --preset orb-sdvl --set tracking.reject_outliers=false\n  \
                       visloc slam desk --plots out/desk --json out/desk.json\n  \
                       visloc slam MH_01_easy --from 40s --stride 2 --scale 0.5\n  \
                       visloc slam sim:room --plots out/room\n  \
                       visloc slam clip.mp4 --camera camera.toml --save room.vmap\n  \
                       visloc slam later.mp4 --camera camera.toml --load room.vmap --save room.vmap\n  \
                       visloc slam photos --poses poses.tum --save room.vmap\n  \
                       visloc slam clip.mp4 --camera camera.toml --points clip.ply\n  \
                       visloc slam v4l2:/dev/video0 --camera camera.toml --points desk.ply"
)]
pub struct SlamArgs {
    /// Folder of the sequence, sim:NAME, bag, video, v4l2:DEVICE, ros2:TOPIC, ... (see: visloc sources)
    #[arg(value_name = "SOURCE")]
    pub source: InputName,
    #[command(flatten)]
    pub parameters: SlamParametersArgs,
    /// When tracking and mapping run [default: sequential; threaded for live sources]
    #[arg(long, value_parser = named(SCHEDULES))]
    pub schedule: Option<Schedule>,
    /// Images come at their stamps; those that wait for more than half a second while tracking is busy are dropped
    #[arg(long)]
    pub realtime: bool,
    /// First image: a number from 0, or seconds after the first image of the sequence with an s (4.5s)
    #[arg(long, value_name = "N|SECS", default_value = "0", alias = "start")]
    pub from: Bound,
    /// One past the last image, as --from [default: all]
    #[arg(long, value_name = "N|SECS", alias = "end")]
    pub until: Option<Bound>,
    /// Stop after this many images
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    /// Use only every Nth image
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..))]
    pub stride: u32,
    /// Size of the images as a factor from 0.05 to 4; the camera is adapted [default: 1, or a whole fraction where a side would be longer than 1600 px]
    #[arg(long, value_name = "FACTOR", value_parser = number)]
    pub scale: Option<f64>,
    /// Options and parameters as ROS 2 programs take them, YAML (docs/ros2.md#parameters); what is typed wins
    #[arg(long, value_name = "FILE")]
    pub params_file: Option<InputPath>,
    /// Publish camera pose, map points and state as ROS 2 topics [default for ros2: sources]
    #[arg(long)]
    pub publish_ros: bool,
    /// Publish nothing
    #[arg(long, conflicts_with = "publish_ros")]
    pub no_publish_ros: bool,
    /// Go on in this map of an earlier run (.vmap): the camera is looked for in it at first
    #[arg(long, value_name = "FILE")]
    pub load: Option<InputMap>,
    /// Keep the map in this file (.vmap); one that was there is kept as FILE~
    #[arg(long, value_name = "FILE")]
    pub save: Option<OutputMap>,
    /// Make the map of --save from the images that have a pose in this file (TUM format, EuRoC's CSV): nothing is followed, and the poses stay
    /// as they are. For turntables and single photos
    #[arg(long, value_name = "FILE", requires = "save", conflicts_with_all = [
        "load", "fixed", "publish_ros", "realtime", "schedule", "trajectory", "keyframes", "points", "log", "plots", "record", "publish", "json",
    ])]
    pub poses: Option<InputPath>,
    /// Only find the camera in the map of --load and follow it there; the map stays as it is
    #[arg(long, requires = "load", conflicts_with = "save")]
    pub fixed: bool,
    /// Write the pose of every frame to this file, TUM format
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<OutputFile>,
    /// Write the poses of the keyframes to this file, TUM format
    #[arg(long, value_name = "FILE")]
    pub keyframes: Option<OutputFile>,
    /// Write the landmarks to this file, PLY
    #[arg(long, value_name = "FILE", alias = "map")]
    pub points: Option<OutputFile>,
    /// Write state, matches and times of every frame to this file, CSV
    #[arg(long, value_name = "FILE")]
    pub log: Option<OutputFile>,
    /// Draw pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub plots: Option<OutputFolder>,
    #[command(flatten)]
    pub overwrite: OverwriteArg,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub options: SourceArgs,
    #[command(flatten)]
    pub topics: TopicArgs,
    #[command(flatten)]
    pub broadcast: BroadcastArgs,
}
