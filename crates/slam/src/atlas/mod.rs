//! Several maps, and places that are seen again: keyframes are compared with all earlier ones; where three in a row agree, two
//! maps are joined or a loop is closed.

mod certainty;
mod closing;
mod global;
mod meeting;
mod merge;
mod pose_graph;
mod recognizer;
mod revisit;
mod sighting;

pub use meeting::Meeting;
pub use merge::{Apart, Merged, merge};
pub use pose_graph::{PoseGraph, PoseGraphEdge};
pub(crate) use recognizer::IN_A_ROW;
pub use recognizer::Recognizer;
pub(crate) use revisit::was_seen_again;
pub use visloc_core::geom::Similarity;
