//! Running SLAM over a sequence: the loop, its records, its numbers and its files.

mod drive;
mod input;
mod pace;
mod pictures;
mod ply;
mod record;
mod report;
mod show;

pub use drive::{RunOptions, SlamRun, run};
pub use input::{SlamInput, open_input};
pub use pace::Pace;
pub use pictures::{FramePictures, draw};
pub use ply::write_ply;
pub use record::{SlamRecord, write_log};
pub use report::SlamReport;
pub use show::SlamShow;
