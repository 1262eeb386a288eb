//! Markov localization on a grid: belief along a walk, localization from images, the goalkeeper's way, and recovery after
//! many observations without a goal.
//!
//! Source: section 5 and 6 of the paper on Markov localization for the goalkeeper of the Standard Platform League.

mod experiment;
mod goalkeeper;
mod goalless;
mod pictures;
mod report;
mod stage;
mod tables;
mod walk;

pub use experiment::{Captures, MarkovExperiment, MarkovRecord, MarkovSettings};
pub use goalkeeper::{GoalkeeperRecord, Keeper};
pub use goalless::{Blindness, GoallessCell, GoallessRecord};
pub use walk::WalkRecord;

#[cfg(test)]
mod tests;
