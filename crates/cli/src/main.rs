//! `visloc`: tells a robot with one ordinary camera where it is.

mod args;
mod broadcast;
mod calibration;
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

use clap::Parser;

fn main() -> ExitCode {
    match commands::execute(args::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // One line, outermost context first, so that scripts and people find the place at once.
            let _ = writeln!(io::stderr(), "error: {}", one_line(&error));
            ExitCode::FAILURE
        }
    }
}

/// The message with its causes. A cause that the message before already quotes is not said twice.
fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if !line.contains(&cause) {
            let separator = if line.is_empty() { "" } else { ": " };
            line = line + separator + &cause;
        }
    }
    line.replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use anyhow::anyhow;

    use super::one_line;

    #[test]
    fn a_quoted_cause_is_said_once() {
        let error = anyhow!("no such file").context("x.mcap: no such file").context("cannot start");
        assert_eq!(one_line(&error), "cannot start: x.mcap: no such file");
    }
}
