//! One file per command: from checked arguments to results.

mod colors;
mod config;
mod demo;
mod evaluate;
mod execute;
mod experiment;
mod likelihood;
mod localize;
mod map;
mod settings;
mod simulate;
mod study;
mod slam;

pub use execute::execute;
