//! One file per command: from checked arguments to results.

mod benchmark;
mod calibrate;
mod calibrate_robot;
mod camera;
mod check_camera;
mod colors;
mod config;
mod convert;
mod cut;
mod demo;
mod demo_slam;
mod evaluate;
mod evaluate_camera;
mod execute;
#[cfg(feature = "experiments")]
mod experiment;
mod extract;
#[cfg(feature = "experiments")]
mod likelihood;
mod localize;
mod locate;
mod map;
mod map_merge;
mod record;
mod simulate;
mod slam;
mod sources;
#[cfg(feature = "experiments")]
mod study;
mod visual_map;

pub use evaluate::reliabilities_in;
pub use execute::execute;
#[cfg(feature = "experiments")]
pub use experiment::merged;
