//! `visloc demo` and `visloc simulate`.

use clap::{Args, ValueEnum};

use super::{
    InputName, JsonArg, OutputFolder, OutputRecording, OverwriteArg, SeedArg, ThreadsArg, number::whole,
};

/// Arguments of `visloc demo`.
#[derive(Debug, Args)]
#[command(
    long_about = "Simulates a robot that walks over a RoboCup field and is kidnapped twice: somebody lifts it and puts \
                  it down elsewhere, the second time without any sign from its feet. Two algorithms look for it in the \
                  same images, and you watch them. At the end: a table of both and a folder with pictures.\n\n\
                  On a terminal the demo plays at up to twice real time. In a pipe it runs as fast as it can and prints \
                  a few plain lines.\n\n\
                  `visloc demo slam` carries a camera through a furnished room instead, without any map.",
    after_long_help = "Examples:\n  \
                       visloc demo\n  \
                       visloc demo --seed 7 --out out/seven      another walk, other kidnaps\n  \
                       visloc demo --scenario crowd              among other robots (see: visloc simulate --list)\n  \
                       visloc demo slam                          a camera without a map"
)]
pub struct DemoArgs {
    /// What is shown
    #[arg(value_enum, value_name = "WHAT", default_value_t = DemoKind::Field)]
    pub kind: DemoKind,
    #[command(flatten)]
    pub seed: SeedArg,
    /// Folder for pictures, trajectories and numbers [default: out/demo, out/demo-slam]
    #[arg(
        long,
        value_name = "DIR",
        visible_alias = "plots",
        default_value = "out/demo",
        default_value_if("kind", "slam", "out/demo-slam"),
        hide_default_value = true
    )]
    pub out: OutputFolder,
    /// Built-in scenario or TOML file; for slam: room, hall, walking or kidnap [default: demo, room]
    #[arg(long, value_name = "NAME|FILE")]
    pub scenario: Option<InputName>,
    /// Stop after this many frames
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub threads: ThreadsArg,
}

/// What a demo shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DemoKind {
    /// A robot on a field whose lines are known
    Field,
    /// A camera in a room that nobody knows: where it was, and a map of what it saw
    Slam,
}

impl DemoArgs {
    /// What is simulated.
    pub fn scenario(&self) -> &str {
        let usual = match self.kind {
            DemoKind::Field => "demo",
            DemoKind::Slam => "room",
        };
        self.scenario.as_deref().map_or(usual, scenario_name)
    }
}

/// A scenario as it is named here, where nothing else can be meant: `sim:NAME`, its name as a source, is understood as well.
fn scenario_name(given: &str) -> &str {
    given.strip_prefix("sim:").unwrap_or(given)
}

/// Arguments of `visloc simulate`.
#[derive(Debug, Args)]
#[command(
    long_about = "Draws what a simulated robot sees and writes it as a ROS 2 bag: images, calibration, kinematics, \
                  odometry and foot sensors, and the truth on a topic of its own. The truth is also written beside the \
                  bag as a trajectory in TUM format.\n\n\
                  A path that ends in .mcap becomes one file, any other a folder with metadata.yaml that \
                  `ros2 bag play` understands.",
    after_long_help = "Examples:\n  \
                       visloc simulate --list\n  \
                       visloc simulate kidnaps                              writes out/kidnaps.mcap\n  \
                       visloc simulate tour --out out/tour.mcap --seed 3\n  \
                       visloc localize out/tour.mcap --map robocup-spl-2010"
)]
pub struct SimulateArgs {
    /// Built-in scenario or TOML file
    #[arg(value_name = "SCENARIO", required_unless_present = "list")]
    pub scenario: Option<InputName>,
    /// The bag: FILE.mcap or a folder [default: out/SCENARIO.mcap]
    #[arg(long, value_name = "BAG")]
    pub out: Option<OutputRecording>,
    #[command(flatten)]
    pub overwrite: OverwriteArg,
    /// List the built-in scenarios and do nothing else
    #[arg(long, exclusive = true)]
    pub list: bool,
    /// Stop after this many frames
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub threads: ThreadsArg,
}

impl SimulateArgs {
    /// What is simulated.
    pub fn scenario(&self) -> Option<&str> {
        self.scenario.as_deref().map(scenario_name)
    }
}
