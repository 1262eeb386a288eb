//! The map: keyframes and landmarks in arenas, addressed by number. Numbers are never used twice.

mod keyframe;
mod landmark;
mod shared_vec;
mod store;

pub use keyframe::{Keyframe, KeyframeId};
pub use landmark::{Landmark, LandmarkId, LandmarkState, Observation};
pub use store::{Map, NewKeyframe};
