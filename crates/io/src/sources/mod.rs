//! Everything that frames come from, behind one argument.
//!
//! [`SourceAddress::parse`] understands what a user writes (`sim:robocup`, `run.mcap`, `tum:DIR`, `clip.mp4`,
//! `v4l2:/dev/video0`, `ros2:/camera/image`), and one of three functions opens it:
//!
//! * [`open_frames`]: all that a robot senses, for localization on a known map;
//! * [`open_images`]: gray images of a calibrated camera, for SLAM;
//! * [`open_pictures`]: pictures of any camera, for calibration and for looking at.
//!
//! What a kind of source cannot deliver itself is made of what it can: gray images of pictures and a calibration, frames of
//! pictures and a camera that is fixed on the robot. A new kind is one file in `kinds/` and its line in the list there.
//!
//! Libraries have no clock and print nothing; whoever opens a source lends it both as a [`Host`].

mod adapt;
mod address;
mod error;
mod kinds;
mod open;
mod options;
mod source_option;
mod video;

pub use adapt::{ManyCameras, UntilStopped};
pub use address::SourceAddress;
pub use error::SourcesError;
pub use kinds::{KINDS, SourceKind, notes_on_folder, simulated_scenario};
pub use open::{OpenFrames, OpenImages, OpenPictures, open_frames, open_images, open_pictures};
pub use options::{Purpose, SourceOptions, TopicOptions, Usual};
pub use source_option::{FORWARD_M, HEIGHTS_M, PATIENCES_SECS, RATES_HZ, SourceOption};
pub use video::{PnmImage, read_pnm};
pub use visloc_core::Host;
