//! Solvers: pose of one camera, bundles of cameras and points, two rays.

mod bundle;
mod normal;
mod pose;
mod skyline;
mod three_points;
mod triangulate;

pub use bundle::{
    Bundle, BundleLens, BundleMotion, BundleObservation, BundleReport, BundleSettings, BundleTie,
};
pub use pose::{
    PoseObservation, PosePrior, Rejection, RobustPose, State, pose_covariance, refine_pose, refine_turn,
    robust_pose,
};
pub use skyline::Skyline;
pub use three_points::{MOST_POSES, poses_from_three_points};
pub use triangulate::{cos_parallax, triangulate};
