//! How many places that look the same does a localizer keep, and for how long?
//!
//! Source: 2017 section 5.1, with all tables. Beside the published criterion (an individual near every position) stands
//! a strict one (near every position a quarter of its fair share), and beside the localizers a null control, particles
//! that know nothing: they meet the published criterion.

mod contenders;
mod experiment;
mod notes;
mod pictures;
mod report;
mod tables;
mod timing;

pub use experiment::{SymmetryExperiment, SymmetryPart, SymmetryRecord, SymmetrySettings};
pub use timing::{IterationTime, measure};
