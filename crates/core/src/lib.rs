//! What every part of visloc passes around: time stamps, seeded random streams, images, the frames of a robot's sensors, trajectories, and
//! the trait of everything that produces them; geometry and cameras ([`geom`]), parameters as people write them ([`settings`]), and
//! the comparison of an estimate with the truth ([`eval`]).

mod clock;
mod debug_shows;
pub mod diagnosis;
pub mod eval;
pub mod files;
mod frame;
pub mod geom;
mod gray;
mod host;
mod image;
mod image_source;
mod occupancy_grid;
mod rng;
pub mod settings;
mod source;
mod statistics;
mod time;
mod trajectory;
mod with_defaults;
mod worded;

pub use clock::Clock;
pub use frame::{Frame, GroundContact, SourceFrame, Truth};
pub use gray::GrayImage;
pub use host::Host;
pub use image::{ImageSizeError, RgbImage, hue_saturation_brightness};
pub use image_source::{CalibratedImages, GrayFrame, ImageSource, Picture};
pub use occupancy_grid::{Occupancy, OccupancyGrid};
pub use rng::{Rng, RngTree, gaussian};
pub use source::{Mapped, PutBack, SkippedInput, Source, SourceError, SourceStatus};
pub use statistics::{mean, median, quantile};
pub use time::Timestamp;
pub use trajectory::{CameraPose, CameraTrajectory, PlanarTrajectory, Stamped, StampedPose, Trajectory};
