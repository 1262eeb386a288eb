//! Why a run localized nothing, or almost nothing, from what was counted in its images.
//!
//! Each image without a place that can be relied on gets one [`Cause`]: the first that applies on the way from the camera to
//! the pose. [`RunCounters`] counts them while the run goes on; [`RunCounters::diagnosis`] tells the most frequent ones. Sentences
//! are left to whoever shows them.

mod cause;
mod counters;
#[cfg(test)]
mod tests;
mod view;

pub use cause::Cause;
pub use counters::{Diagnosis, Finding, RunCounters, RunFacts};
