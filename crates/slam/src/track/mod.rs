//! Following the camera from frame to frame.

mod align_images;
mod frame;
mod local_map;
mod matcher;
mod prediction;
mod search;
mod tracker;
mod turn;

pub use align_images::{AlignFeature, AlignReference, ImageAlignment};
pub use frame::{Feature, Frame, FrameWork, Incoming};
pub use local_map::{LocalMap, collect_local_map};
pub use matcher::{Found, Matcher, whitening};
pub use prediction::{MotionModel, RotationAligner};
pub(crate) use search::FOUND_AT_RIGHT;
pub use tracker::{MATCH_LIMITS, Quality, TrackReport, Tracker, depth_spread, focal_px, scene_depth};
pub(crate) use turn::FEW_KNOWN;
pub use turn::only_turned;
