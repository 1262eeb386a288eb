//! Options of several commands.

use std::{net::SocketAddr, thread};

use clap::Args;

use super::{DriveArgs, OutputFile, OutputRecording, number::whole};

/// The seed of everything random.
#[derive(Debug, Clone, Copy, Args)]
pub struct SeedArg {
    /// Seed of everything random; the same seed gives the same result, bit by bit [default: 1]
    #[arg(long = "seed", value_name = "SEED", value_parser = whole::<u64>(0..))]
    pub given: Option<u64>,
}

impl SeedArg {
    /// The seed asked for, or the usual one.
    pub fn value(self) -> u64 {
        self.given.unwrap_or(1)
    }
}

/// Where the numbers go.
#[derive(Debug, Clone, Args)]
pub struct JsonArg {
    /// Write all numbers to this file as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<OutputFile>,
}

/// How a list is printed.
#[derive(Debug, Clone, Args)]
pub struct ListArgs {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// What others may see of a run.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "For the studio")]
pub struct BroadcastArgs {
    /// Record everything that there is to see: .mcap for visloc studio --replay, .rrd for the Rerun viewer (if visloc was
    /// built with it)
    #[arg(long, value_name = "FILE")]
    pub record: Option<OutputRecording>,
    /// Let visloc studio --connect watch from another computer; frames come at their stamps then
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = address_and_port)]
    pub publish: Option<SocketAddr>,
    /// What those who watch must know [default: a random one, printed]
    #[arg(long, value_name = "TOKEN", requires = "publish", value_parser = token)]
    pub token: Option<String>,
    #[command(flatten)]
    pub drive: DriveArgs,
}

/// A secret that can stand in an address and on a command line as it is.
pub fn token(text: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.~".contains(c);
    if text.is_empty() || !text.chars().all(is_plain) {
        return Err("expected letters, digits, -, _, . or ~, at least one".to_owned());
    }
    Ok(text.to_owned())
}

/// An address of this computer with a port.
fn address_and_port(text: &str) -> Result<SocketAddr, String> {
    let numbers = text.strip_prefix("localhost:").map(|port| format!("127.0.0.1:{port}"));
    numbers.as_deref().unwrap_or(text).parse().map_err(|_| {
        "expected an address of this computer and a port, such as 127.0.0.1:7979, or 0.0.0.0:7979 for all that reach it".to_owned()
    })
}

/// How many threads draw.
#[derive(Debug, Clone, Copy, Args)]
pub struct ThreadsArg {
    /// Threads that draw simulated images; changes the speed, never the result [default: all cores]
    #[arg(long = "threads", value_name = "N", value_parser = whole::<u16>(1..=256))]
    threads: Option<u16>,
}

impl ThreadsArg {
    /// The number asked for.
    pub fn given(self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    /// The number asked for, or one for each core.
    pub fn count(self) -> usize {
        self.given().unwrap_or_else(num_cores)
    }
}

/// One thread for each core.
pub fn num_cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}
