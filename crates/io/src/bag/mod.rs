//! Recordings of a robot: bags of ROS 2 in MCAP or SQLite, and of ROS 1.
//!
//! [`BagReader`] turns a recording into frames, [`BagWriter`] frames into a recording. In between stands the
//! [`Synchronizer`], which joins messages of several topics by their stamps in one pass, so it serves live topics too.
//!
//! Data flow of the reader: files -> [`BagMessages`] -> [`SensorMessage`] -> [`Synchronizer`] -> frames. What kind of file it is,
//! and whether of ROS 1, is known up to [`BagMessages`] only.

mod channels;
mod choose;
mod container;
mod decode;
mod error;
mod files;
mod given;
mod history;
mod index;
mod joints;
mod level;
pub mod messages;
mod metadata;
mod pictures;
mod reader;
mod results;
mod schemas;
mod stream;
mod sync;
mod tf_tree;
mod topics;
mod transcode;
mod writer;

pub use container::{BagMessage, Channel, DamagedBag};
pub use decode::{
    EncodedImage, ImagePayload, Reject, RosMessage, SensorMessage, StampedTransform, camera_of,
};
pub use error::BagError;
pub(crate) use files::files_without_metadata;
pub use given::GivenInputs;
pub use index::TopicInfo;
pub(crate) use index::recorded_topics;
pub use pictures::BagPictures;
pub use reader::BagReader;
pub use results::{
    ResultFrames, ResultMessage, ResultMessages, ResultSample, covariance_on_ground, diagnostics_message,
    in_space, on_ground,
};
pub use schemas::definition;
pub use stream::BagMessages;
pub(crate) use sync::MAX_SKIPPED;
pub use sync::{ExpectedInputs, SyncOutcome, SynchronizedFrame, Synchronizer};
pub use topics::{BagTopics, ImageQos, TopicRole};
pub use transcode::Transcoder;
pub use writer::{BagWriter, BagWriterOptions, ChunkCompression, ImageEncoding, camera_info_message};
