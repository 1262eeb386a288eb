//! Repeatable experiments.
//!
//! An [`Experiment`] is a list of cells, each with a number of runs. A run is a pure function of the cell, the run's
//! number and the seed, so the runs can be done in parallel, in parts on many machines ([`Shard`]), and after an
//! interruption go on where they stopped ([`run`], [`merge`]). What the runs found becomes a [`Report`] with tables,
//! numbers and pictures.

mod framework;
pub mod kidnap;
pub mod likelihood;
pub mod markov;
pub mod office;
pub mod positions;
mod published;
pub mod robocup;
pub mod slam;
pub mod studies;
pub mod symmetry;
pub mod team;

pub use framework::{
    Cell, Experiment, ExperimentError, Manifest, Report, Results, RunOptions, RunProgress, RunTarget, Shard,
    merge, run, run_until, work_until,
};
pub(crate) use framework::{mean, number, percent, quantile, ratio, sorted};
pub use published::{PublishedTable, published_tables};
pub use visloc_plot::Table;
