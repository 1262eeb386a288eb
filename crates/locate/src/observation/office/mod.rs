//! Likelihood of poses inside a building, from theoretical lines near the pose.
//!
//! Source: 2017 section 5.3.2. `lines` makes the building's theoretical lines, `index` says which of them can be seen from
//! where, [`OfficeObservationModel`] projects these and compares pixels with them.

mod features;
mod index;
mod lines;
mod model;
mod propose;
mod sector;
mod shadows;
mod sights;
mod view;

pub use features::OfficeFeatureModel;
pub use model::{OfficeModelConfig, OfficeObservationModel};

#[cfg(test)]
mod tests;
