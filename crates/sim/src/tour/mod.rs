//! A camera of its own, without a robot: it is carried through a textured room along a smooth path, for SLAM.
//!
//! `place` furnishes the room, `path` says where the camera is, `source` takes the pictures. A new tour is a line in
//! [`TOURS`] and its branch in `path` or `place`.

mod path;
mod place;
mod source;

pub use source::{CameraTour, TourError};

/// What a tour is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TourKind {
    /// Once around a furnished room and a little on, looking across it.
    Room,
    /// Through a hall, looking ahead and to the side.
    Hall,
    /// A sideways step, then nearly still, while people walk through the picture.
    Walking,
    /// Around the room; dark for a moment, put down on another spot that was seen before.
    Kidnap,
}

/// Names of the tours, with what happens.
pub const TOURS: [(&str, TourKind, &str); 4] = [
    ("room", TourKind::Room, "once around a furnished room and a little on (20 s)"),
    ("hall", TourKind::Hall, "once around a hall, looking to the side (30 s)"),
    ("walking", TourKind::Walking, "nearly still, two people walk through the picture (15 s)"),
    ("kidnap", TourKind::Kidnap, "around a room; covered for 2 s and put down elsewhere (24 s)"),
];
