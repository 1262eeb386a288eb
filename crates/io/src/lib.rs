//! Everything that images come from and results go to: recordings of a robot ([`bag`]: ROS 2 and ROS 1), datasets ([`sequence`]), images,
//! trajectories, calibrations and robot descriptions ([`urdf`]) in files, live topics (`ros2`, a feature), and all of them and more behind one argument ([`sources`]).
//!
//! A recording is read as a stream: memory does not grow with its length, and a damaged or cut file gives every frame
//! up to the damage.
//!
//! ```no_run
//! use visloc_core::Source;
//! use visloc_io::bag::{BagReader, BagTopics};
//!
//! let mut bag = BagReader::open("recording.mcap", BagTopics::default())?;
//! while let Some(frame) = bag.next_item() {
//!     let frame = frame?.frame;
//!     println!("{}: {} x {} px", frame.at, frame.image.width(), frame.image.height());
//! }
//! println!("{} messages were left out", bag.status().skipped.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod backlog;
pub mod bag;
pub mod camera_file;
pub mod camera_trajectory;
mod file_error;
pub mod image_codec;
pub mod raw_image;
#[cfg(feature = "ros2")]
pub mod ros2;
mod ros_lens;
mod ros_parameters;
pub mod sequence;
pub mod sources;
mod text;
pub mod trajectory;
pub mod urdf;

pub use file_error::FileError;
pub use ros_parameters::read_ros_parameters;
