//! One file per command: from checked arguments to results.

mod colors;
mod config;
mod demo;
mod demo_slam;
mod evaluate;
mod evaluate_camera;
mod execute;
mod experiment;
mod likelihood;
mod localize;
mod map;
mod settings;
mod simulate;
mod slam;
mod studio;
mod study;

pub use execute::execute;
