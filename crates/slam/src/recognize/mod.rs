//! Recognizing a place: one mechanism for a lost camera, for loops and for joining maps.
//!
//! An image is described by the ORB descriptors of its corners ([`View`]); an index that grows with the map ([`PlaceIndex`]) names
//! the keyframes that look alike; a candidate counts once geometry agrees ([`Locator`]): a pose from descriptors, and the landmarks
//! around it found again by their patches.

mod agreement;
mod index;
mod lists;
mod locate;
mod pairs;
mod refusal;
mod relocator;
mod support;
mod view;

pub use index::{Alike, PlaceIndex, Ranked};
pub use locate::{Located, Locator, Rival};
pub(crate) use locate::{SURE, frame_of};
pub(crate) use pairs::{LESS_THAN_SECOND, MOST_DIFFERENT};
pub use pairs::{Pair, pair_views};
pub use refusal::Refusal;
pub use relocator::Relocator;
pub(crate) use relocator::are_apart;
pub(crate) use view::ShortPlace;
pub use view::{Described, View};
