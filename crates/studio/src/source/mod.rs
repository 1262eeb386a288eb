//! Frames and images that come from elsewhere: recordings, cameras, live topics.
//!
//! `feed` reads a source on a thread of its own, so that a source for which one has to wait holds up nobody; `session` shows
//! algorithms at work on frames.

mod feed;
mod session;

pub use feed::{Fed, Feed};
pub use session::{FramesOpener, OpenRun, SourceSession};
