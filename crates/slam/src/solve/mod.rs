//! Solvers: pose of one camera, bundles of cameras and points, two rays.

mod bundle;
mod normal;
mod pose;
mod skyline;
mod three_points;
mod triangulate;

pub(crate) use bundle::LEAST_GAIN;
pub use bundle::{
    Bundle, BundleErrors, BundleLens, BundleMotion, BundleObservation, BundleReport, BundleSettings,
    BundleTie,
};
pub use pose::{
    PoseObservation, PosePrior, Rejection, RobustPose, State, pose_covariance, pose_covariance_among,
    refine_pose, refine_turn, robust_pose,
};
pub use skyline::{Skyline, SkylineFactor};
pub use three_points::{MOST_POSES, poses_from_three_points};
pub use triangulate::{cos_parallax, triangulate};

/// Step of numeric derivatives by angles, logarithms and shares.
pub(crate) const STEP: f64 = 1e-6;
