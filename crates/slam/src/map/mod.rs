//! The map: keyframes and landmarks in arenas, addressed by number. Numbers are never used twice. The arenas hold all maps that
//! were started; each keyframe knows which one it belongs to.

mod crossing;
mod keyframe;
mod landmark;
mod observations;
mod picture;
mod several;
mod shared_vec;
mod store;
mod stored;

pub use crossing::{Crossing, Standing};
pub use keyframe::{Keyframe, KeyframeId, MapId, SessionCamera};
pub use landmark::{Landmark, LandmarkId, LandmarkState};
pub(crate) use observations::push_tightly;
pub use observations::{Observation, Observations};
pub use picture::{KeyframePicture, Pack, PackedPicture, Packing, PictureShelf, Unpack};
pub use several::{Correction, Offsets};
pub(crate) use store::most_shared;
pub use store::{Map, NewKeyframe, scaled};
pub use stored::{RestoreError, Restoring, StoredKeyframe, StoredLandmark, StoredMap, StoredObservation};
