//! Analysis of images of a RoboCup field: border pixels of lines and goals.
//!
//! scan lines (`scan`) -> runs of one color -> border pixels (`edges`) -> filters -> random discard -> percept.
//! Beside that, composite features (`features`) from the same borders and runs, and robots and balls (`objects`) if somebody asks for them.

mod analyzer;
mod bare;
mod blobs;
mod carpet;
mod cells;
mod config;
mod edges;
mod features;
mod field_end;
mod isolation;
mod objects;
mod obstacles;
mod scan;

pub use analyzer::FieldAnalyzer;
pub use blobs::GoalBlob;
pub(super) use carpet::STEP_PX;
pub use config::{FieldAnalysisConfig, FilterSwitches};
pub use features::FeatureDetectionConfig;
pub use field_end::FieldEnd;
pub use obstacles::Obstacle;
