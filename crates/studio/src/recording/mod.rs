//! Recordings of what pages are shown, for later study.
//!
//! A recording is an MCAP file (<https://mcap.dev>) without chunks, with three channels of message encoding
//! `visloc-studio`, whose messages are those of [`crate::Message`]:
//!
//! * `/studio/scene`: what stays; written again when it changes, always before the states that it belongs to
//! * `/studio/image`: the camera image of the state that follows
//! * `/studio/state`: what is true at a moment; its log time is that moment, nanoseconds since the first frame
//!
//! Without chunks a frame is found by its place in the file, so a recording of hours is replayed without reading it into memory,
//! and one that was cut off is good up to the cut.

mod annotations;
mod index;
mod recorder;
mod replay;
mod timeline;

pub use annotations::{Annotation, AnnotationKind, annotate};
pub use index::{RecordingError, RecordingIndex};
pub use recorder::Recorder;
pub use replay::Replay;
pub use timeline::{Lane, Row, row_of};
