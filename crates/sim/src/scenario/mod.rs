//! What happens in a simulation, as data: a TOML file in `scenarios/`.
//!
//! `load` reads and checks a file, `camera`, `robot`, `motion` and `world` are its tables, `factors` make it harder. Every key is optional
//! except `map`; defaults are in the `Default` of each table.

mod camera;
mod check;
mod factors;
mod load;
mod motion;
mod robot;
mod world;

pub use camera::{CameraSetup, FurtherCamera};
pub use factors::Factor;
pub(crate) use load::FIRST_STAMP;
pub use load::{BUILT_IN_SCENARIOS, MAX_FRAMES, Scenario, ScenarioError};
pub use motion::{Carry, Motion, PlacedPose, Stand, Turn, Walk, Wander};
pub use robot::{FootSetup, GaitSetup, HeadMount, HeadSetup, KinematicsSetup, OdometrySetup, RobotSetup};
pub use world::{Ball, BoxPiece, FurniturePiece, LightFade, LightSetup, OtherRobot, Panel, PersonSetup};
