//! Video files and cameras, decoded by ffmpeg in a process of its own.
//!
//! ffmpeg writes every image with a small header (PGM or PPM) into a pipe, so that the size need not be known before, and its
//! time to standard error. A recorded video waits in the pipe until somebody reads on; of a live one a thread keeps the newest
//! image.

mod ffmpeg;
mod live;
mod open;
mod pictures;
mod pipe;
mod pnm;

pub(crate) use ffmpeg::{FfmpegInput, ffmpeg_problem};
pub(crate) use open::{Decoded, frames, images, pictures};
pub(crate) use pnm::Pixels;
pub use pnm::{PnmImage, read_pnm};
