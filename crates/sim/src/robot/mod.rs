//! The robot and its sensors besides the camera: where it walks (`floor`, `path`, `plan`), how its camera moves
//! (`body`), what it reports (`odometry`, `feet`), and the other robots (`others`).

mod body;
mod feet;
mod floor;
mod odometry;
mod others;
mod path;
mod plan;

pub(crate) use body::Body;
pub(crate) use feet::Feet;
pub(crate) use floor::Floor;
pub(crate) use odometry::Odometry;
pub(crate) use others::{Orbit, find_orbits};
pub(crate) use plan::{Activity, MotionPlan};
