//! SLAM without a map on sequences of the user's or of the simulator, beside the published figures.
//!
//! Source: 2017 section 7.1 (configurations, dynamic scenes, kidnap) and 7.2 (comparison). Five experiments of the same cells, a
//! sequence and a configuration each: what the parts of the algorithm are worth, when a
//! keyframe should be made, what moving things do to it, how a camera that
//! was carried away is found, and how it compares with other programs.
//!
//! The times in the records are measured while the runs are done. They are the only part of a record that another run does not
//! repeat; everything else is a function of sequence, configuration, run and seed.

mod experiment;
mod follow;
mod map_pictures;
mod pictures;
mod report;
mod sequence;

pub use experiment::{SlamExperiment, SlamSettings, SlamStudy};
pub use follow::SlamRunRecord;
