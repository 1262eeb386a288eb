//! Several maps, and places that are seen again: keyframes are compared with all earlier ones; where three in a row agree, two
//! maps are joined or a loop is closed.

mod meeting;
mod recognizer;
mod sighting;
mod similarity;

pub use meeting::Meeting;
pub use recognizer::Recognizer;
pub use similarity::Similarity;
