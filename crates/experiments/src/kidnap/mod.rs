//! How fast is a localizer that has converged found again after somebody carried the robot away?
//!
//! One position in a square of 20 m x 20 m, likelihood `0.01 + 0.99 exp(-d^2 / 2)`. After 200 iterations it jumps by at
//! least 8 m. A run has recovered as soon as more than half of all individuals, explorers included, are within 2 m of
//! the new position, at most 200 iterations later.

mod contenders;
mod experiment;
mod pictures;
mod report;

pub use experiment::{KidnapExperiment, KidnapRecord, KidnapSettings};
