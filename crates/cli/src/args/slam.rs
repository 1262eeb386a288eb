//! `visloc slam`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{JsonArg, SeedArg};

/// Parameters of SLAM.
#[derive(Debug, Clone, Args)]
pub struct SlamParametersArgs {
    /// Parameters to start from: sdvl, orb-sdvl, or one of the eight configurations of the thesis, config1 to config8
    #[arg(long, value_name = "NAME", default_value = "sdvl")]
    pub preset: String,
    /// Parameters, TOML; names only what differs from the preset
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// One parameter, over preset and file; can be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// When tracking and mapping run.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ScheduleArg {
    /// One after the other; the same seed gives the same result, bit by bit
    Sequential,
    /// Mapping has a thread of its own and tracking never waits for it
    Threaded,
}

/// Arguments of `visloc slam`.
#[derive(Debug, Args)]
#[command(
    long_about = "Follows one calibrated camera through a sequence of images without a map, and makes a sparse map of what \
                  it sees. If the sequence has the truth, the result is compared with it.\n\n\
                  SEQUENCE is a folder with rgb.txt (lines 'SECONDS FILE') and camera.yaml (width, height, fx, fy, cx, \
                  cy, distortion), and maybe groundtruth.txt.\n\n\
                  One camera knows no scale: lengths are in map units, the median depth at the start is 1.",
    after_long_help = "Examples:\n  \
                       visloc slam desk --trajectory desk.tum --map desk.ply\n  \
                       visloc slam desk --preset orb-sdvl --set tracking.reject_outliers=false\n  \
                       visloc slam desk --plots out/desk --json out/desk.json"
)]
pub struct SlamArgs {
    /// Folder of the sequence
    #[arg(value_name = "SEQUENCE")]
    pub sequence: PathBuf,
    #[command(flatten)]
    pub parameters: SlamParametersArgs,
    /// When tracking and mapping run
    #[arg(long, value_enum, default_value_t = ScheduleArg::Sequential)]
    pub schedule: ScheduleArg,
    /// Images come at their stamps; those that come while tracking is busy are dropped
    #[arg(long)]
    pub realtime: bool,
    /// First image, from 0
    #[arg(long, default_value_t = 0)]
    pub start: usize,
    /// One past the last image [default: all]
    #[arg(long)]
    pub end: Option<usize>,
    /// Use every how manyeth image
    #[arg(long, default_value_t = 1)]
    pub stride: usize,
    /// Write the pose of every frame to this file, TUM format
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Write the poses of the keyframes to this file, TUM format
    #[arg(long, value_name = "FILE")]
    pub keyframes: Option<PathBuf>,
    /// Write the landmarks to this file, PLY
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Write state, matches and times of every frame to this file, CSV
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Draw pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub plots: Option<PathBuf>,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
}
