//! Live ROS 2 topics without a ROS installation: a client over DDS, the network protocol below ROS 2.
//!
//! [`LiveFrames`] and [`LivePictures`] subscribe to a robot's sensors, [`ResultPublisher`] says where the robot is and takes
//! orders. Messages and their meaning are those of bags (`visloc_io::bag`): the same synchronizer joins them.
//!
//! Data flow: DDS -> one thread that receives -> inbox -> whoever asks for the next frame, in its own thread. The inbox is
//! bounded, and whoever is too slow for all images gets the newest.

mod drive;
mod error;
mod frames;
mod inbox;
mod node;
mod pictures;
mod publish;
mod receive;
mod services;
mod team;
#[cfg(test)]
mod tests;
mod vigil;

pub use drive::{DrivePublisher, DriveTopics};
pub use error::Ros2Error;
pub use frames::LiveFrames;
pub use node::{LiveTopic, Network, Node, NodeSettings};
pub use pictures::LivePictures;
pub use publish::{Order, PublishSettings, ResultPublisher, occupancy_grid, point_cloud};
pub use receive::LiveSettings;
pub use services::Middleware;
pub use team::TeamLink;
