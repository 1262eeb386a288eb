//! Behavior of the simulator as a whole.

// Clippy knows test functions, but not their helpers.
#![allow(clippy::unwrap_used)]

mod frames;
mod labels;
mod pictures;
mod scenarios;
