//! Recordings of what pages are shown, for later study.
//!
//! A recording is an MCAP file (<https://mcap.dev>) without chunks, with channels of message encoding
//! `visloc-studio`, whose messages are those of [`crate::Message`]:
//!
//! * `/studio/scene`: what stays; written again when it changes, always before the states that it belongs to
//! * `/studio/image`: the camera image of the state that follows
//! * `/studio/state`: what is true at a moment
//! * `/studio/input`: the exact numbers that the algorithms were given for the state that follows
//!
//! Beside them stands the input as the ordinary ROS 2 topics of a bag, images as PNG, where it is known. So a recording can be
//! recomputed, and is a bag for other commands and tools. All messages of a frame have the time of its image; without
//! input it is counted from the first frame.
//!
//! Without chunks a frame is found by its place in the file, so a recording of hours is replayed without reading it into memory,
//! and one that was cut off is good up to the cut.

mod annotations;
mod index;
mod input;
mod recorder;
mod tape;
mod timeline;

pub use annotations::{Annotation, AnnotationKind, annotate};
pub use index::{RecordingError, RecordingIndex};
pub(crate) use input::CameraInput;
pub use input::Input;
pub use recorder::Recorder;
pub use tape::Tape;
pub use timeline::{Lane, Row, row_of};
