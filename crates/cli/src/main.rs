//! `visloc`: tells a robot with one ordinary camera where it is.

mod args;
mod broadcast;
mod calibration;
mod claims;
mod commands;
mod host;
mod live_view;
mod report;
mod run;
mod say;
mod slam;
mod stopwatch;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches};

fn main() -> ExitCode {
    let result = run();
    if let Err(error) = &result {
        // One line, outermost context first, so that scripts and people find the place at once.
        let _ = writeln!(io::stderr(), "error: {}", say::one_line(error));
        return ExitCode::FAILURE;
    }
    if host::host().was_interrupted() {
        let _ = writeln!(io::stderr(), "interrupted; what was computed until then is saved");
        return ExitCode::from(host::INTERRUPTED);
    }
    ExitCode::SUCCESS
}

fn run() -> Result<()> {
    let mut command = args::Cli::command();
    command.build();
    let matches = command.clone().get_matches();
    let cli = args::Cli::from_arg_matches(&matches)
        .map_err(|error| error.format(&mut command))
        .unwrap_or_else(|error| error.exit());
    claims::Claims::of(&command, &matches).check()?;
    commands::execute(cli)
}
