//! `visloc calibrate-robot`, and the corrections that it writes.

use clap::Args;

use super::{
    InputName, InputPath, JsonArg, OutputFile, SeedArg, SourceArgs, ThreadsArg, TopicArgs, number::whole,
};

/// Corrections of what a recording says.
#[derive(Debug, Clone, Default, Args)]
pub struct CorrectionArgs {
    /// Corrections of the camera's pose and of the odometry, TOML, as visloc calibrate-robot writes them
    #[arg(long, value_name = "FILE")]
    pub robot: Option<InputPath>,
}

/// Arguments of `visloc calibrate-robot`.
#[derive(Debug, Args)]
#[command(
    long_about = "Finds out from a short drive over a known field what is always wrong with a robot: how far its camera looks lower \
                  or higher, is rolled, or sits higher than it reports, and by which factors its odometry is off. The result is \
                  a file for visloc localize --robot.\n\n\
                  Drive for a minute or more over all of the field, ahead, to the sides if the robot can, with turns. The run is \
                  repeated with the corrections until they no longer change.",
    after_long_help = "Examples:\n  \
                       visloc calibrate-robot drive.mcap --map my-field.toml --out robot.toml\n  \
                       visloc localize game.mcap --map my-field.toml --robot robot.toml"
)]
pub struct CalibrateRobotArgs {
    /// A drive: ROS 2 bag (.mcap or folder), sim:SCENARIO, or another source of `visloc sources`
    #[arg(value_name = "SOURCE")]
    pub source: InputName,
    /// Built-in map or TOML file; may be left out with sim:SCENARIO
    #[arg(long, value_name = "NAME|FILE")]
    pub map: Option<InputName>,
    /// Write the corrections to this file, TOML
    #[arg(long, value_name = "FILE")]
    pub out: Option<OutputFile>,
    /// Most passes over the recording
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u32>(1..=10))]
    pub passes: u32,
    /// Stop after this many frames
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub corrections: CorrectionArgs,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub threads: ThreadsArg,
    #[command(flatten)]
    pub options: SourceArgs,
    #[command(flatten)]
    pub topics: TopicArgs,
}
