//! From a source of frames through one or more pipelines to files, records and a spectator.
//!
//! `source` opens what the user names, `runner` is one algorithm with its output files, `drive` is the loop.

mod corrected;
mod drive;
mod output;
mod progress;
mod runner;
mod source;

pub use corrected::{corrected, read_correction, with_correction};
pub use drive::{FrameView, RunOutcome, Spectator, drive};
pub use output::{OutputFiles, write_text};
pub use progress::Progress;
pub use runner::{FrameRecord, PixelCounts, Runner, RunnerSettings};
pub use source::{SourceSettings, open_source, simulation};
