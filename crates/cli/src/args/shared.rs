//! Options of several commands.

use std::{path::PathBuf, thread};

use clap::Args;

/// The seed of everything random.
#[derive(Debug, Clone, Copy, Args)]
pub struct SeedArg {
    /// Seed of everything random; the same seed gives the same result, bit by bit
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Where the numbers go.
#[derive(Debug, Clone, Args)]
pub struct JsonArg {
    /// Write all numbers to this file as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// How many threads draw.
#[derive(Debug, Clone, Copy, Args)]
pub struct ThreadsArg {
    /// Threads that draw simulated images; changes the speed, never the result [default: all cores]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
}

impl ThreadsArg {
    /// The number asked for, or one for each core.
    pub fn count(self) -> usize {
        self.threads.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from)
    }
}
