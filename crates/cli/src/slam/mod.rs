//! Running SLAM over a sequence: the loop, its records, its numbers and its files.

mod drive;
mod given;
mod history;
mod input;
#[cfg(feature = "ros2")]
mod live;
#[cfg(not(feature = "ros2"))]
#[path = "no_ros2.rs"]
mod live;
mod map_file;
mod map_watcher;
#[cfg(feature = "ros2")]
mod named_maps;
mod pace;
mod pictures;
mod ply;
mod record;
mod report;

pub use drive::{Lookers, MapWay, RunOptions, SlamAudience, SlamRun, SlamWatcher, run};
pub use given::map_given_poses;
pub use history::{SlamHistory, StageSums};
pub use input::{open_input, range_of};
#[cfg(feature = "ros2")]
pub use live::landmark_cloud;
pub use live::open_slam_live;
pub use map_file::{damages_in_words, is_map_of_slam, load_fixed_map, load_map, save_map};
pub use map_watcher::{MapFrame, MapView, MapWatcher, MapWish};
#[cfg(feature = "ros2")]
pub use named_maps::NamedMaps;
pub use pace::Pace;
pub use pictures::{FramePictures, draw};
pub use ply::write_ply;
pub use record::{SlamRecord, write_log};
pub use report::{POSE_TOLERANCE_SECS, SlamReport};
