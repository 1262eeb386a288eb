//! Localization in an office corridor whose doors look alike.
//!
//! Source: 2017 section 5.3. A zigzag walk along both legs of the corridor, and a walk that starts in front of a door and is
//! interrupted by two kidnaps, each with Monte Carlo and with the evolutionary algorithm; and the observation model as a map
//! of the corridor: how sharply it tells places apart, which places look the same, what a hidden door and a thing that looks
//! like a door do to it.

mod experiment;
mod likelihood;
mod oracle;
mod place;
mod report;
mod walk;

pub use experiment::{OfficeExperiment, OfficeRecord, OfficeSettings};
