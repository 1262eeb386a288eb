//! Image analysis: from a camera image to the few pixels that a localizer weighs.
//!
//! The result is a [`Percept`], the same type for every world: labelled feature pixels, the camera they were seen with,
//! and the quality of the image. [`field::FieldAnalyzer`] makes percepts on a RoboCup field,
//! [`office::OfficeAnalyzer`] inside a building.
//! Sources: master's thesis of 2010, section 4.2; doctoral thesis of 2017, sections 5.2.1 and 5.3.1.

pub mod color;
pub mod field;
mod field_features;
mod image_look;
pub mod office;
mod percept;

pub use field_features::{
    CenterCircle, FieldFeatures, GoalPost, Junction, JunctionKind, LineSegment, PenaltyMark, PostColor,
    PostSide,
};
pub use image_look::ImageLook;
pub use percept::{
    AnalysisError, BorderPixel, DoorSide, DropReason, DroppedPixel, FeatureKind, FeaturePixel, PerceivedBlob,
    Percept,
};
