//! The localizers on the RoboCup field: tours, kidnaps with and without a lift signal, other robots, white goals.
//!
//! Every run has a simulation of its own, so way, textures, light, sensor errors and noise differ. The published figures
//! stand beside the measured ones. Two proofs go with them: whether a reported reliability means something, and whether a
//! reported covariance does. Source of the experiments: 2010 chapter 5, 2017 section 5.2.
//!
//! `sets` makes the scenarios, `track` lets a contender work on the frames, `score` and `reliability` make its record,
//! `summary` and `tables` make many records one table.

mod chi_square;
mod experiment;
mod mirror;
mod pictures;
mod record;
mod reliability;
mod report;
mod score;
mod sets;
mod summary;
mod tables;
mod timing;
mod track;

pub use chi_square::{chi_square_cdf, chi_square_quantile, mean_band_95};
pub use experiment::{RobocupExperiment, RobocupSettings};
pub use mirror::{is_mirror_nearer, mirrored, mirrored_covariance};
pub use record::{
    Calibration, Consistency, ContenderRecord, KidnapScore, RobocupRecord, TracePoint, TruthPoint,
};
pub use reliability::NEAR_M;
pub use sets::{RobocupSet, RunLength};
pub use timing::{AlgorithmTiming, measure};
