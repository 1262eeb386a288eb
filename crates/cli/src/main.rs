//! `visloc`: tells a robot with one ordinary camera where it is.

mod args;
mod commands;
mod live_view;
mod report;
mod run;
mod say;
mod stopwatch;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use clap::Parser;

fn main() -> ExitCode {
    match commands::execute(args::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // One line, outermost context first, so that scripts and people find the place at once.
            let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
            let _ = writeln!(io::stderr(), "error: {}", causes.join(": ").replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}
