//! Image analysis, lift detector and localizer for the frames of one robot.

mod algorithm;
mod analyzer;
mod builder;
mod config;
mod photo;
mod run;
#[cfg(test)]
mod tests;
mod world_parts;

pub(crate) use algorithm::algorithm_on;
pub use algorithm::algorithm_parameters;
pub use analyzer::{ImageAnalyzer, analysis_for};
pub use builder::PipelineBuilder;
pub use config::{FeatureChoice, OfficePipelineConfig, PipelineConfig};
pub use photo::{Photo, PhotoAnswer, PhotoError, PhotoPose, locate_photo};
pub use run::{Pipeline, StepTimes};
pub use world_parts::feature_model;
