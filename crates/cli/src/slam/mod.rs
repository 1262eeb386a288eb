//! Running SLAM over a sequence: the loop, its records, its numbers and its files.

mod drive;
mod input;
mod pictures;
mod ply;
mod record;
mod report;

pub use drive::{SlamRun, run};
pub use input::{SlamInput, open_input};
pub use pictures::{FramePictures, draw};
pub use ply::write_ply;
pub use record::{SlamRecord, write_log};
pub use report::SlamReport;
