//! Recordings of a robot: ROS 2 bags in MCAP files.
//!
//! [`BagReader`] turns a recording into frames, [`BagWriter`] frames into a recording. In between stands the
//! [`Synchronizer`], which joins messages of several topics by their stamps in one pass, so it serves live topics too.
//!
//! Data flow of the reader: files -> records -> raw messages -> [`SensorMessage`] -> [`Synchronizer`] -> frames.

mod channels;
mod decode;
mod error;
mod files;
mod history;
mod index;
pub mod messages;
mod metadata;
mod pictures;
mod reader;
mod records;
mod results;
mod schemas;
mod stream;
mod sync;
mod tf_tree;
mod topics;
mod writer;

pub use decode::{
    EncodedImage, ImagePayload, Reject, RosMessage, SensorMessage, StampedTransform, camera_of,
};
pub use error::BagError;
pub use index::TopicInfo;
pub use pictures::BagPictures;
pub use reader::BagReader;
pub use results::{ResultFrames, ResultMessage, ResultMessages, ResultSample, diagnostics_message};
pub use schemas::definition;
pub use sync::{ExpectedInputs, SyncOutcome, SynchronizedFrame, Synchronizer};
pub use topics::{BagTopics, TopicRole};
pub use writer::{BagWriter, BagWriterOptions, ChunkCompression, ImageEncoding, camera_info_message};
