//! Descriptions of robots (URDF): which links there are, and which joints are between them.
//!
//! Only what kinematics needs is read: names, parents, origins, axes and mimicked joints. Meshes, masses, limits and plugins are passed
//! over, so no other file is opened.

mod description;
mod parse;
#[cfg(test)]
mod tests;

pub use description::{Joint, JointMotion, Mimic, MovedLinks, RobotDescription};
pub use parse::read_robot_description;
