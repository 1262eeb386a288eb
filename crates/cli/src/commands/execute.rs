//! Which command runs.

use anyhow::Result;

use super::{
    benchmark, calibrate, calibrate_robot, camera, check_camera, colors, config, demo, evaluate, extract,
    localize, locate, map, record, simulate, slam, sources,
};
#[cfg(feature = "experiments")]
use super::{experiment, likelihood, study};
use crate::args::{Cli, Command};
#[cfg(feature = "studio")]
use crate::studio;

/// Does what the command line asks for.
pub fn execute(cli: Cli) -> Result<()> {
    match cli.command {
        Command::Demo(args) => demo::execute(&args),
        Command::Simulate(args) => simulate::execute(&args),
        Command::Localize(args) => localize::execute(&args),
        Command::Locate(args) => locate::execute(&args),
        Command::Slam(args) => slam::execute(&args),
        Command::Record(args) => record::execute(&args),
        Command::Extract(args) => extract::execute(&args),
        Command::Sources(args) => sources::execute(&args),
        #[cfg(feature = "studio")]
        Command::Studio(args) => studio::execute(&args),
        #[cfg(not(feature = "studio"))]
        Command::Studio(_) => left_out("studio"),
        Command::Evaluate(args) => evaluate::execute(&args),
        Command::Benchmark(args) => benchmark::execute(&args),
        #[cfg(feature = "experiments")]
        Command::Experiment(args) => experiment::execute(&args),
        #[cfg(not(feature = "experiments"))]
        Command::Experiment(_) => left_out("experiments"),
        #[cfg(feature = "experiments")]
        Command::Likelihood(args) => likelihood::execute(&args),
        #[cfg(not(feature = "experiments"))]
        Command::Likelihood(_) => left_out("experiments"),
        #[cfg(feature = "experiments")]
        Command::Study(args) => study::execute(&args),
        #[cfg(not(feature = "experiments"))]
        Command::Study(_) => left_out("experiments"),
        Command::Algorithms(args) => config::list_algorithms(&args),
        Command::Maps(args) => map::list(&args),
        Command::Config(args) => config::execute(&args),
        Command::Map(args) => map::execute(&args),
        Command::Calibrate(args) => calibrate::execute(&args),
        Command::CalibrateRobot(args) => calibrate_robot::execute(&args),
        Command::CheckCamera(args) => check_camera::execute(&args),
        Command::Camera(args) => camera::execute(&args),
        Command::Colors(args) => colors::execute(&args),
    }
}

/// Says how to get a command that was left out.
#[cfg(not(all(feature = "experiments", feature = "studio")))]
fn left_out(feature: &str) -> Result<()> {
    anyhow::bail!(
        "this command was left out when visloc was built; build it with --features {feature}, or everything with --features full"
    )
}
