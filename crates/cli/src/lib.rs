//! The program `visloc`: [`main`]; and what of it reads files that nothing else reads, for who hands it damaged ones.

mod args;
mod benchmark;
mod calibration;
mod claims;
mod commands;
mod host;
mod in_map;
mod live_view;
mod params_file;
mod report;
mod run;
mod say;
mod settings;
mod slam;
mod stopwatch;
#[cfg(feature = "studio")]
mod studio;
#[cfg(not(feature = "studio"))]
#[path = "no_studio.rs"]
mod studio;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use anyhow::Result;
use clap::{
    Command, CommandFactory, FromArgMatches,
    error::{ContextKind, ErrorKind},
};

pub use benchmark::{report_again, sequence_in};
#[cfg(feature = "experiments")]
pub use commands::merged;
pub use commands::reliabilities_in;

/// Does what the command line says.
pub fn main() -> ExitCode {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    host::return_blocks_of_messages();
    host::watch_signals();
    let result = run();
    let (said, code) = match &result {
        Err(_) if host::is_stopped_before_begin() => {
            (host::NOTHING_YET.to_owned(), ExitCode::from(host::INTERRUPTED))
        }
        // What is missing then is not the fault of the input.
        Err(error) if host::host().was_interrupted() => (
            format!("interrupted before the end: {}", say::one_line(error)),
            ExitCode::from(host::INTERRUPTED),
        ),
        // One line, outermost context first, so that scripts and people find the place at once.
        Err(error) => (format!("error: {}", say::one_line(error)), ExitCode::FAILURE),
        Ok(()) if host::host().was_interrupted() => {
            let said = match host::is_stopped_before_begin() {
                true => host::NOTHING_YET,
                false => "interrupted; what was computed until then is saved",
            };
            (said.to_owned(), ExitCode::from(host::INTERRUPTED))
        }
        Ok(()) => match say::fault() {
            None => return ExitCode::SUCCESS,
            Some(fault) => (format!("error: {}", say::one_line(&fault)), ExitCode::FAILURE),
        },
    };
    let _ = writeln!(io::stderr(), "{said}");
    code
}

/// Ends the program with a mistake of the command line. Nobody who mistypes an option wants to pass it as a value, so that tip is
/// left out.
fn end(mut error: clap::Error) -> ! {
    if error.kind() == ErrorKind::UnknownArgument {
        error.remove(ContextKind::Suggested);
    }
    if !error.use_stderr() {
        // Help.
        say::text(format_args!("{}", error.render()));
        if let Some(fault) = say::fault() {
            let _ = writeln!(io::stderr(), "error: {}", say::one_line(&fault));
            std::process::exit(1);
        }
        std::process::exit(0);
    }
    error.exit()
}

/// The command whose options take `-3` for a number rather than for an option, so that they can say what they expect.
fn taking_negative_numbers(command: Command) -> Command {
    let names: Vec<String> = command.get_subcommands().map(|below| below.get_name().to_owned()).collect();
    let command = command.mut_args(|arg| match arg.get_action().takes_values() && !arg.is_positional() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    });
    names.into_iter().fold(command, |command, name| command.mut_subcommand(name, taking_negative_numbers))
}

fn run() -> Result<()> {
    let mut command = taking_negative_numbers(args::Cli::command());
    command.build();
    let typed: Vec<_> = std::env::args_os().collect();
    let (words, params_file) = params_file::with_params_file(&command, typed.clone())?;
    let matches = match (command.clone().try_get_matches_from(words), params_file) {
        (Ok(matches), _) => matches,
        (Err(error), None) => end(error),
        (Err(error), Some(path)) => match command.clone().try_get_matches_from(typed) {
            Err(own) if own.kind() != ErrorKind::MissingRequiredArgument => end(own),
            _ => return Err(params_file::at_fault(&path, &error)),
        },
    };
    let cli = args::Cli::from_arg_matches(&matches)
        .map_err(|error| error.format(&mut command))
        .unwrap_or_else(|error| error.exit());
    let claims = claims::Claims::of(&command, &matches);
    claims.check()?;
    if claims.takes_standard_output() {
        say::aside();
    }
    let result = commands::execute(cli);
    claims.say_kept();
    result
}
