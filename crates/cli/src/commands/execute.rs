//! Which command runs.

use anyhow::Result;

use super::{
    benchmark, calibrate, calibrate_robot, camera, check_camera, colors, config, demo, evaluate, experiment,
    extract, likelihood, localize, map, record, simulate, slam, sources, studio, study,
};
use crate::args::{Cli, Command};

/// Does what the command line asks for.
///
/// # Errors
/// Whatever stops the command, with the place where it happened.
pub fn execute(cli: Cli) -> Result<()> {
    match cli.command {
        Command::Demo(args) => demo::execute(&args),
        Command::Simulate(args) => simulate::execute(&args),
        Command::Localize(args) => localize::execute(&args),
        Command::Slam(args) => slam::execute(&args),
        Command::Record(args) => record::execute(&args),
        Command::Extract(args) => extract::execute(&args),
        Command::Sources(args) => sources::execute(&args),
        Command::Studio(args) => studio::execute(&args),
        Command::Evaluate(args) => evaluate::execute(&args),
        Command::Benchmark(args) => benchmark::execute(&args),
        Command::Experiment(args) => experiment::execute(&args),
        Command::Likelihood(args) => likelihood::execute(&args),
        Command::Study(args) => study::execute(&args),
        Command::Algorithms => {
            config::list_algorithms();
            Ok(())
        }
        Command::Maps => map::list(),
        Command::Config(args) => config::execute(&args),
        Command::Map(args) => map::execute(&args),
        Command::Calibrate(args) => calibrate::execute(&args),
        Command::CalibrateRobot(args) => calibrate_robot::execute(&args),
        Command::CheckCamera(args) => check_camera::execute(&args),
        Command::Camera(args) => camera::execute(&args),
        Command::Colors(args) => colors::execute(&args),
    }
}
