//! A scenario comes to life: `world` builds the scene, `states` works out what robot and sensors do at every frame,
//! `source` takes the pictures. `live` needs no plan: somebody steers. `team` is several of those in one
//! world, and `detector` says what each of them would see of the others.

mod detector;
mod live;
mod source;
mod states;
mod team;
mod world;

pub use detector::{Detection, DetectorSetup};
pub use live::{LiveControls, LiveMotion, LiveSimulation};
pub use source::Simulation;
pub use team::{TeamFrame, TeamSimulation};
