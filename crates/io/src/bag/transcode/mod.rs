//! Messages of ROS 1 as messages of ROS 2: [`Transcoder`].
//!
//! A recording of ROS 1 holds the definition of each message type. ROS 1 writes the fields one after another, ROS 2 (CDR) in the
//! same order at multiples of their sizes. What differs else: the header has no number any more, times are messages, and names
//! of fields are lower case.

mod definition;
mod transcoder;

pub use transcoder::Transcoder;
