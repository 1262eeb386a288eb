//! Localization with a known map: observation models, motion model, and the localizers that use them.
//!
//! A [`Localizer`] turns percepts and odometry into an [`Estimate`]. It knows the world only through an
//! [`ObservationModel`], so the same localizer runs on every map. [`Pipeline`] ties image analysis, lift detector and
//! localizer together for a robot's frames.
//!
//! Sources: master's thesis of 2010, chapters 4 and 5; doctoral thesis of 2017, chapters 4 and 5.

mod algorithm;
mod camera_misalignment;
mod config;
pub mod diagnosis;
mod estimate;
pub mod evolutionary;
mod lift;
pub mod lineup;
mod localizer;
pub mod markov;
pub mod monte_carlo;
mod motion;
pub mod observation;
mod odometer;
mod per_camera;
mod pipeline;
mod prior;
pub mod refine;
mod region;
mod reliability;
pub mod robot_calibration;
pub mod team;
pub mod vision;

pub use algorithm::{ALGORITHMS, Algorithm, AlgorithmInfo};
pub use camera_misalignment::{CameraMisalignment, Uncertain};
pub use config::{ConfigError, require};
pub use estimate::{Estimate, Hypothesis, LOCALIZED_RELIABILITY};
pub use lift::{LiftConfig, LiftDetector};
pub use localizer::{Individual, Localizer, StepInput};
pub use motion::{MotionConfig, MotionModel, PlanarMotion};
pub use observation::{Landmark, ObservationModel};
pub use pipeline::{
    FeatureChoice, ImageAnalyzer, OfficePipelineConfig, Photo, PhotoAnswer, PhotoError, PhotoPose, Pipeline,
    PipelineBuilder, PipelineConfig, StepTimes, algorithm_parameters, analysis_for, feature_model,
    locate_photo,
};
pub use prior::{Half, HeadingPrior, PosePrior, SideLines, StartPrior};
pub use region::Region;
pub use reliability::{Reliability, ReliabilityConfig};
