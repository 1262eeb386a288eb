//! A scenario comes to life: `world` builds the scene, `states` works out what robot and sensors do at every frame,
//! `source` takes the pictures. `live` needs no plan: somebody steers (`driven` as a source of frames). `team` is several of those in one
//! world, and `detector` says what each of them would see of the others.

mod detector;
mod driven;
mod live;
mod source;
mod states;
mod team;
mod world;

pub use detector::{Detection, DetectorSetup};
pub use driven::DrivenSimulation;
pub use live::{LiveControls, LiveMotion, LiveSimulation};
pub use source::Simulation;
pub use team::{TEAM, TeamFrame, TeamSimulation};
