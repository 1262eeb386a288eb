//! Compares an estimated trajectory with the truth: errors, how soon and how long the robot knew where it was, and how
//! it recovered after somebody carried it away. No input or output happens here.
//!
//! ```
//! use visloc_core::{PlanarTrajectory, StampedPose, Timestamp};
//! use visloc_core::eval::{EstimateSample, EvaluationOptions, evaluate};
//! use visloc_core::geom::PlanarPose;
//!
//! let at = Timestamp::from_secs(1.0);
//! let mut truth = PlanarTrajectory::new();
//! let pose = StampedPose { at, world_from_robot: PlanarPose::new(1.0, 0.0, 0.0), height_m: 0.0 };
//! truth.push(pose).expect("the first pose has nothing before it");
//! let estimate = [EstimateSample { at, world_from_robot: PlanarPose::new(1.1, 0.0, 0.0), reliability: Some(0.9) }];
//! let evaluation = evaluate(&truth, &estimate, &EvaluationOptions::default());
//! assert_eq!(evaluation.frames, 1);
//! assert!((evaluation.position_error_m.mean.unwrap() - 0.1).abs() < 1e-12);
//! ```

mod association;
pub mod camera;
mod carried;
mod evaluation;
mod options;
mod recovery;
mod summary;

pub use association::EstimateSample;
pub use carried::{CarriedSpan, carried_spans};
pub use evaluation::{Evaluation, FrameError, evaluate};
pub use options::EvaluationOptions;
pub use recovery::KidnapRecovery;
pub use summary::{ErrorSummary, TimingSummary};
