//! What a run is worth: numbers for scripts, tables for people, pictures for both.

mod analysis_picture;
mod camera_errors;
mod diagnosis;
mod ground_pose;
mod json;
mod list;
mod map_lines;
mod overlay;
mod pictures;
mod skipped;
mod table;

pub use analysis_picture::SnapshotTaker;
pub use camera_errors::{CameraReport, camera_pictures};
pub use diagnosis::{
    FindingReport, NOT_RECOGNIZED, diagnosis_lines, explain_localization, explain_photo, explain_tracking,
};
pub use ground_pose::{GroundPose, pose_in_words};
pub use json::{
    AlgorithmReport, CameraOfRobot, DemoReport, EvaluationReport, LocalizeReport, SimulateReport, save_json,
};
pub use list::{Listed, print_list};
pub use map_lines::map_lines;
pub use overlay::draw_overlay;
pub use pictures::{Curve, RunPictures, ground};
pub use skipped::SkippedReport;
pub use table::{Column, comparison_table, measure, percent};
