//! What every part of visloc passes around: time stamps, seeded random streams, images, the frames of a robot's
//! sensors, trajectories, and the trait of everything that produces frames.

mod frame;
mod image;
mod rng;
mod time;
mod trajectory;

pub use frame::{Frame, FrameSource, GroundContact, SkippedInput, SourceError, SourceFrame, Truth};
pub use image::{ImageSizeError, RgbImage};
pub use rng::{Rng, RngTree, gaussian};
pub use time::Timestamp;
pub use trajectory::{PlanarTrajectory, StampedPose};
