//! The map: keyframes and landmarks in arenas, addressed by number. Numbers are never used twice. The arenas hold all maps that
//! were started; each keyframe knows which one it belongs to.

mod keyframe;
mod landmark;
mod several;
mod shared_vec;
mod store;

pub use keyframe::{Keyframe, KeyframeId, MapId};
pub use landmark::{Landmark, LandmarkId, LandmarkState, Observation};
pub use several::{Correction, Offsets};
pub use store::{Map, NewKeyframe, scaled};
