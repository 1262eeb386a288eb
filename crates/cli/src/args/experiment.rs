//! `visloc experiment`.

use clap::{Args, Subcommand};
use visloc_experiments::{Shard, robocup::RobocupSet};
use visloc_locate::FeatureChoice;

use super::{
    InputName, InputPath, JsonArg, OutputFolder, SeedArg,
    named::named,
    number::{whole, within},
};

/// Arguments of `visloc experiment`.
#[derive(Debug, Args)]
pub struct ExperimentArgs {
    /// Which experiment.
    #[command(subcommand)]
    pub command: ExperimentCommand,
}

/// All experiments.
#[derive(Debug, Subcommand)]
pub enum ExperimentCommand {
    /// Places that look the same: which algorithms keep all of them, and for how long?
    Symmetry(SymmetryArgs),
    /// Carried away: how fast do algorithms that had converged find the new place?
    Kidnap(CellArgs),
    /// Markov localization on a grid: walks, images, a goalkeeper, long times without a goal
    Markov(MarkovArgs),
    /// On the field: tours, kidnaps, other robots, white goals; are reliability and covariance honest?
    #[command(
        long_about = "Lets the algorithms look for a simulated robot, many times, and compares them with the published figures.\n\n\
                      Sets: tours (a walk over the field), no-odometry (the same without odometry), crowd (other robots, boards, \
                      uneven light), kidnaps (the feet notice), unfelt (only the camera can notice), white (kidnaps on a field with \
                      white goals, where every place has a mirror image; each algorithm plays twice, once it is told the half).\n\n\
                      A full run of everything takes hours of one core. With --out it can be stopped and goes on where it \
                      stopped."
    )]
    Robocup(RobocupArgs),
    /// An office corridor whose doors look alike: a walk, two kidnaps, maps of the likelihood
    Office(OfficeArgs),
    /// Teams of 2 to 5 robots on a field with white goals, one of which knows its half: bad links, restarts, liars
    Team(TeamArgs),
    /// SLAM: what bundle adjustment, outlier rejection and descriptors are worth
    SlamConfigs(SlamStudyArgs),
    /// SLAM: what share of lost points should ask for a keyframe
    SlamLostPoints(SlamStudyArgs),
    /// SLAM among moving things, with and without outlier rejection
    SlamDynamic(SlamStudyArgs),
    /// SLAM of a camera that is covered and carried away
    SlamKidnap(SlamStudyArgs),
    /// SLAM beside the published figures of other programs
    SlamCompare(SlamStudyArgs),
    /// Put the parts of an experiment together
    Merge(MergeArgs),
}

/// Options of all experiments.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
                       visloc experiment NAME --out out/run             run again to go on after an interruption\n  \
                       visloc experiment NAME --out part2 --shard 2/8   one of eight jobs of a cluster\n  \
                       visloc experiment merge part1 part2 part3 part4 part5 part6 part7 part8 --out out/run")]
pub struct RunsArgs {
    /// Keep every run's result, tables and pictures in this folder; runs that are there are not done again
    #[arg(long, value_name = "DIR")]
    pub out: Option<OutputFolder>,
    /// Do one part of the runs only: 2/8 is the second of eight
    #[arg(long, value_name = "K/N", default_value_t = Shard::WHOLE)]
    pub shard: Shard,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
    /// Runs that are done at the same time; changes the speed, never the result [default: all cores]
    #[arg(long, value_parser = whole::<u16>(1..=1024))]
    pub threads: Option<u16>,
}

/// Arguments of `visloc experiment symmetry`.
#[derive(Debug, Args)]
pub struct SymmetryArgs {
    /// Runs of each cell of the tables [default: 100; 1000 with --long]
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=1_000_000))]
    pub runs: Option<u64>,
    /// Instead of the published tables: 3,000 iterations, up to 8 positions, at most 120 individuals
    #[arg(long)]
    pub long: bool,
    #[command(flatten)]
    pub common: RunsArgs,
}

/// Arguments of `visloc experiment kidnap`.
#[derive(Debug, Args)]
pub struct CellArgs {
    /// Runs of each cell of the tables
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = whole::<u64>(1..=1_000_000))]
    pub runs: u64,
    #[command(flatten)]
    pub common: RunsArgs,
}

/// Arguments of `visloc experiment markov`.
#[derive(Debug, Args)]
pub struct MarkovArgs {
    /// Learn the observation tables from this recording with truth (.mcap, a field with the published goals); states that it
    /// does not show keep the tables that come with the program
    #[arg(long, value_name = "BAG")]
    pub recording: Option<InputPath>,
    #[command(flatten)]
    pub cells: CellArgs,
}

/// Arguments of `visloc experiment robocup`.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
                       visloc experiment robocup --quick                                a first look\n  \
                       visloc experiment robocup --set kidnaps --algorithm evolutionary\n  \
                       visloc experiment robocup --out out/robocup                      run again to go on after an interruption")]
pub struct RobocupArgs {
    /// Kind of runs; may be given several times [default: all]
    #[arg(long = "set", value_name = "NAME")]
    pub sets: Vec<RobocupSet>,
    /// Name of an algorithm (see: visloc algorithms); may be given several times [default: all]
    #[arg(long = "algorithm", value_name = "NAME")]
    pub algorithms: Vec<String>,
    /// What the pose is computed from
    #[arg(long, value_parser = named(FEATURES), default_value = "rich")]
    pub features: &'static [FeatureChoice],
    /// Runs of each kind, each with another walk, light and sensor errors [default: 20; 2 with --quick]
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=100_000))]
    pub seeds: Option<u64>,
    /// Short runs, and few of them
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    pub common: RunsArgs,
}

/// Arguments of `visloc experiment office`.
#[derive(Debug, Args)]
pub struct OfficeArgs {
    /// Scenarios of the simulator, or recordings (.mcap) with map.yaml beside them [default: the simulator's office scenarios]
    #[arg(value_name = "PLACE")]
    pub places: Vec<InputName>,
    /// Name of an algorithm (see: visloc algorithms); may be given several times [default: mce, evolutionary]
    #[arg(long = "algorithm", value_name = "NAME")]
    pub algorithms: Vec<String>,
    /// Runs of each cell of the table; each takes a quarter of a minute
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = whole::<u64>(1..=1_000_000))]
    pub runs: u64,
    #[command(flatten)]
    pub common: RunsArgs,
}

/// Arguments of `visloc experiment team`.
#[derive(Debug, Args)]
pub struct TeamArgs {
    /// Games for each number of robots; each takes half a minute or more
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = whole::<u64>(1..=1_000_000))]
    pub runs: u64,
    /// Length of a game, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = within(1.0, 3600.0))]
    pub secs: f64,
    #[command(flatten)]
    pub common: RunsArgs,
}

/// Arguments of the SLAM experiments.
#[derive(Debug, Args)]
pub struct SlamStudyArgs {
    /// Folders of datasets, or sim:NAME; sequences of the documents are told by their folders' names and get the published
    /// figures beside them [default: sequences of the simulator]
    #[arg(value_name = "SEQUENCE")]
    pub sequences: Vec<InputName>,
    /// Runs of each sequence and configuration
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u64>(1..=100_000))]
    pub runs: u64,
    /// Use this many images of each sequence at most
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub common: RunsArgs,
}

/// What the pose is computed from.
const FEATURES: &[(&str, &[FeatureChoice], &str)] = &[
    ("rich", &[FeatureChoice::Rich], "All border pixels refine what the algorithm finds"),
    ("pixels", &[FeatureChoice::Pixels], "Twenty pixels, as in the documents"),
    ("both", &[FeatureChoice::Rich, FeatureChoice::Pixels], "Every algorithm plays with each of them"),
];

/// Arguments of `visloc experiment merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folders of the parts
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<InputPath>,
    /// Runs of each cell [default: as many as the experiment does]
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=1_000_000))]
    pub runs: Option<u64>,
    /// Write tables and pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<OutputFolder>,
    #[command(flatten)]
    pub json: JsonArg,
}
