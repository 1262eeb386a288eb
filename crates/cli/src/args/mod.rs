//! The command line as it is typed. Parsing looks at nothing but the words; files are opened by the commands.

mod analyze;
mod benchmark;
mod calibrate;
mod calibrate_robot;
mod camera;
mod demo;
mod drive;
#[cfg(feature = "experiments")]
mod experiment;
mod inspect;
#[cfg(feature = "experiments")]
mod likelihood;
mod localize;
mod locate;
mod named;
mod number;
mod paths;
mod shared;
mod slam;
mod source;
mod start;
#[cfg(feature = "studio")]
mod studio;
#[cfg(feature = "experiments")]
mod study;

pub use analyze::{ColorsArgs, EvaluateArgs, TrajectoryKind};
pub use benchmark::BenchmarkArgs;
pub use calibrate::{CalibrateArgs, PatternArgs};
pub use calibrate_robot::{CalibrateRobotArgs, CorrectionArgs};
pub use camera::{CameraArgs, CameraCommand, CheckCameraArgs};
use clap::{Parser, Subcommand};
pub use demo::{DemoArgs, DemoKind, SimulateArgs};
pub use drive::DriveArgs;
#[cfg(feature = "experiments")]
pub use experiment::{ExperimentArgs, ExperimentCommand, MergeArgs, RobocupArgs, RunsArgs, SlamStudyArgs};
pub use inspect::{ConfigArgs, ConfigCommand, MapAlignArgs, MapArgs, MapCommand, TextOutArg};
#[cfg(feature = "experiments")]
pub use likelihood::{HeadingText, LikelihoodArgs};
pub use localize::{LocalizeArgs, TopicArgs};
pub use locate::LocateArgs;
pub use paths::{
    InputMap, InputName, InputPath, OutputFile, OutputFolder, OutputMap, OutputRecording, OverwriteArg,
    STANDARD_OUTPUT,
};
pub use shared::{BroadcastArgs, JsonArg, ListArgs, SeedArg, ThreadsArg, num_cores};
pub use slam::{SlamArgs, SlamParametersArgs};
pub use source::{
    ExtractArgs, ExtractFormat, ImageFormat, PictureArgs, PictureSourceArgs, RangeArgs, RecordArgs,
    SourceArgs, SourcesArgs,
};
pub use start::StartArg;
#[cfg(feature = "studio")]
pub use studio::StudioArgs;
#[cfg(feature = "experiments")]
pub use study::StudyArgs;

/// Tells a robot with one ordinary camera where it is
#[derive(Debug, Parser)]
#[command(
    name = "visloc",
    version,
    max_term_width = 100,
    arg_required_else_help = true,
    long_about = "Tells a robot with one ordinary camera where it is: on a known map, such as a RoboCup field, or with a map that it \
                  makes as it goes.\n\n\
                  Nothing is needed for a first look:\n    visloc demo\n\n\
                  Then on a recording of your own robot (a bag of ROS 2 or ROS 1):\n    \
                  visloc localize recording.mcap --map robocup-spl-2010"
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// All commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Watch a simulated robot find itself; needs no files
    Demo(DemoArgs),
    /// Write a simulated robot's recording as a ROS 2 bag, with the truth
    Simulate(SimulateArgs),
    /// Find the robot on a map: in a recording, a simulation, a video, on live topics
    Localize(Box<LocalizeArgs>),
    /// Say where a single photo was taken
    Locate(Box<LocateArgs>),
    /// Open the page: drive a robot, kidnap it, watch algorithms find it
    #[cfg(feature = "studio")]
    Studio(Box<StudioArgs>),
    /// Open the page: drive a robot, kidnap it, watch algorithms find it (not in this build: --features studio)
    #[cfg(not(feature = "studio"))]
    Studio(LeftOutArgs),
    /// Follow one camera without a map, and make a map of what it sees
    Slam(Box<SlamArgs>),
    /// Write what a source delivers as a ROS 2 bag; convert bags
    Record(Box<RecordArgs>),
    /// Write the images of a source into a folder
    Extract(Box<ExtractArgs>),
    /// List what frames can come from, and what works here
    Sources(SourcesArgs),
    /// Compare an estimated trajectory with the truth
    Evaluate(EvaluateArgs),
    /// Measure everything that is claimed, beside published figures and other programs
    Benchmark(BenchmarkArgs),
    /// Repeat the published experiments, and harder ones
    #[cfg(feature = "experiments")]
    Experiment(ExperimentArgs),
    /// Repeat the published experiments, and harder ones (not in this build: --features experiments)
    #[cfg(not(feature = "experiments"))]
    Experiment(LeftOutArgs),
    /// Draw how well every pose explains one image
    #[cfg(feature = "experiments")]
    Likelihood(Box<LikelihoodArgs>),
    /// Draw how well every pose explains one image (not in this build: --features experiments)
    #[cfg(not(feature = "experiments"))]
    Likelihood(LeftOutArgs),
    /// Study what one image tells about the pose, and what disturbs it
    #[cfg(feature = "experiments")]
    Study(StudyArgs),
    /// Study what one image tells about the pose, and what disturbs it (not in this build: --features experiments)
    #[cfg(not(feature = "experiments"))]
    Study(LeftOutArgs),
    /// List the algorithms
    Algorithms(ListArgs),
    /// List the built-in maps
    Maps(ListArgs),
    /// Show the parameters that can be set in files
    Config(ConfigArgs),
    /// Check, import and show maps; info, align, merge, trim and export of those of SLAM
    Map(MapArgs),
    /// Calibrate a camera from pictures of a board
    Calibrate(Box<CalibrateArgs>),
    /// Find out how a robot's camera is mounted and how far its odometry is off, from a short drive
    CalibrateRobot(Box<CalibrateRobotArgs>),
    /// Say whether a calibration is plausible for given images
    CheckCamera(CheckCameraArgs),
    /// Convert calibrations, print boards, draw pictures of boards with known truth
    Camera(CameraArgs),
    /// Learn the color classes of your field from a labelled image
    Colors(ColorsArgs),
}

/// Arguments of a command that was left out of the program: whatever is typed.
#[cfg(not(all(feature = "experiments", feature = "studio")))]
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
pub struct LeftOutArgs {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _words: Vec<std::ffi::OsString>,
}
