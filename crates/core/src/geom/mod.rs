//! Geometry shared by every other crate: angles, typed rigid transforms, planar poses, cameras, planes and the
//! kinematics of the Nao head.
//!
//! Conventions (the full page is `docs/frames.md`):
//! * A transform is named and typed by its frames: `world_from_camera: Rigid3<World, Camera>` takes a point in the
//!   camera frame to the world frame. Points carry their frame in the name: `point_in_world`.
//! * Lengths in meters, angles in radians wrapped to (-pi, pi], pixels with the center of the top-left pixel at (0, 0).

pub mod angle;
mod camera;
mod frames;
mod horizon;
mod lens;
mod mean;
mod mount;
pub mod nao;
mod planar;
mod plane;
mod rigid;
mod similarity;

pub use camera::{Camera, CameraError, MAX_IMAGE_SIDE_PX, ProjectionReject};
pub use frames::{CameraFrame, Odom, Robot, World};
pub use horizon::Horizon;
pub use lens::Distortion;
pub use mean::{PoseStatistics, weighted_pose_statistics};
pub use mount::Mount;
pub use planar::PlanarPose;
pub use plane::Plane;
pub use rigid::{Rigid3, nearest_rotation, renormalized, rotation_vector};
pub use similarity::Similarity;
