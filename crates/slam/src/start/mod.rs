//! The first two keyframes: corners are followed until two views of them explain where the camera went.

mod attempt;
mod confirm;
mod essential;
mod follow;
mod homography;
mod initializer;
mod local_warp;
mod motion;
mod started;
mod two_view;
mod verify;

pub use confirm::{
    PendingStart, SAME_DEVIATION, are_alike, confirm, is_clearly_better, negative_log_likelihood,
};
pub use essential::{decompose_essential, fit_essential};
pub use follow::{Follower, Track};
pub use homography::{decompose_homography, fit_homography};
pub use initializer::{Initializer, StartStep};
pub use motion::{KnownMotion, RayPair, TwoViewMotion, refine_motion, shape_deviation};
pub use started::StartedMap;
pub use two_view::{LostTracks, SURE, StartWait, TwoView, TwoViewSettings, solve_two_view};
pub use verify::{SIGMA_PX, Sight, VerifiedStart, ViewRays, followed_covariance, verify};
