//! A scenario comes to life: `world` builds the scene, `states` works out what robot and sensors do at every frame,
//! `source` takes the pictures.

mod source;
mod states;
mod world;

pub use source::Simulation;
