//! From a source of frames through one or more pipelines to files, records and a spectator.
//!
//! `source` opens what the user names, `runner` is one algorithm with its output files, `drive` is the loop.

mod corrected;
mod drive;
#[cfg(feature = "ros2")]
mod live;
#[cfg(not(feature = "ros2"))]
#[path = "no_ros2.rs"]
mod live;
mod live_report;
mod one_camera;
mod output;
mod progress;
mod records;
mod results;
#[cfg(all(feature = "ros2", feature = "studio"))]
mod ros_drive;
mod runner;
mod saving;
mod source;
mod start_check;
#[cfg(feature = "ros2")]
mod team;

pub use corrected::{corrected, read_correction, with_correction, write_correction};
pub use drive::{FrameView, RunOutcome, Spectator, drive};
pub use live::open_live;
#[cfg(feature = "ros2")]
pub use live::{TF_AHEAD_SECS, obeyed, publish_settings};
pub use live_report::LiveReport;
pub use one_camera::of_one_camera;
pub use output::{OutputFiles, expect_new_folder, print_or_write, write_text};
pub use progress::Progress;
pub use records::Records;
pub use results::BagOutput;
#[cfg(all(feature = "ros2", feature = "studio"))]
pub use ros_drive::RosDriver;
pub use runner::{FrameRecord, PixelCounts, Runner, RunnerSettings};
pub use saving::Saving;
pub use source::{
    OpenSource, open_source, picture_options, prepare, refuse_source_options, simulation, source_options,
    until_stopped,
};
pub use start_check::StartCheck;
#[cfg(feature = "ros2")]
pub use team::{TeamOutput, TeamReport};
