//! Analysis of images of a RoboCup field: border pixels of lines and goals.
//!
//! scan lines (`scan`) -> runs of one color -> border pixels (`edges`) -> filters -> random discard -> percept.

mod analyzer;
mod blobs;
mod config;
mod edges;
mod field_end;
mod obstacles;
mod scan;

pub use analyzer::FieldAnalyzer;
pub use blobs::GoalBlob;
pub use config::{FieldAnalysisConfig, FieldAnalysisConfigError, FilterSwitches};
pub use field_end::FieldEnd;
pub use obstacles::Obstacle;
