//! The program from outside: arguments in, files, exit codes and lines out.

// Helpers of tests are no tests for the lint, but they may stop in the same way.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod bad_inputs;
mod benchmark;
mod broken_bags;
mod calibrate;
mod demo;
mod ends;
mod evaluate;
mod experiment;
mod foreign_bags;
mod guides;
mod help;
mod joints;
mod likelihood;
mod localize;
mod messages;
mod mutations;
mod numbers;
mod outputs;
mod parsers;
mod settings;
mod signals;
mod silence;
#[path = "../../../io/tests/bag/six_joints.rs"]
mod six_joints;
mod slam;
mod slam_input;
mod sources;
mod studio;
mod support;
