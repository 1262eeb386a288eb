//! ORB: oriented FAST corners with rotated binary descriptors, described when they are first compared.

mod corners;
mod descriptor;
mod pattern;

pub use corners::{NoOrbMatch, OrbCorners, OrbMatch, OrbSearch, Recognition};
pub use descriptor::{BoxSums, ORB_MARGIN_PX, OrbDescriptor};
