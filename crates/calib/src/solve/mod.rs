//! The estimation: homographies, a first guess, the refinement.

mod homography;
mod model;
mod refine;
mod start;

pub use homography::{homography, pose_of_plane};
pub use model::{Intrinsics, LensModel, NUM_INTRINSICS};
pub(crate) use refine::residual;
pub use refine::{CameraFromBoard, Observation, RefineSettings, Refined, refine};
pub use start::start;
