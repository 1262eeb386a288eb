//! What all experiments share: doing the runs, keeping what they found, showing it.

mod error;
mod experiment;
mod merge;
mod report;
mod results;
mod runner;
mod shard;
mod statistics;
mod store;

pub use error::ExperimentError;
pub use experiment::{Cell, Experiment};
pub use merge::merge;
pub use report::Report;
pub use results::Results;
pub use runner::{RunOptions, RunProgress, RunTarget, run, run_until, work_until};
pub use shard::Shard;
pub(crate) use statistics::{mean, number, percent, quantile, ratio, sorted};
pub use store::Manifest;
