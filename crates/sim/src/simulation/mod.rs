//! A scenario comes to life: `world` builds the scene, `states` works out what robot and sensors do at every frame,
//! `source` takes the pictures. `live` needs no plan: somebody steers.

mod live;
mod source;
mod states;
mod world;

pub use live::{LiveControls, LiveMotion, LiveSimulation};
pub use source::Simulation;
