//! From a source of frames through one or more pipelines to files, records and a spectator.
//!
//! `source` opens what the user names, `runner` is one algorithm with its output files, `drive` is the loop.

mod drive;
mod output;
mod progress;
mod runner;
mod show;
mod source;

pub use drive::{FrameView, RunOutcome, Spectator, drive};
pub use output::{OutputFiles, write_text};
pub use progress::Progress;
pub use runner::{FrameRecord, PixelCounts, Runner, RunnerSettings};
pub use show::Show;
pub use source::{SourceSettings, open_source, simulation};
