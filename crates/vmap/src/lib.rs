//! Maps that last: what SLAM has learned of a place, in a file (`.vmap`).
//!
//! [`VisualMap`] is what a file holds: keyframes with their images, landmarks with what they look like, cameras, the scale and where
//! it comes from, and the sessions that made it. A file consists of sections, each with its own check sum, so that damage is told by
//! name and costs no more than the section; the layout stands in `docs/map-files.md`.
//!
//! Lengths are in map units, or in meters where the scale is known ([`MapScale`]). While SLAM runs, [`packing`] keeps its images small.

mod align;
mod care;
mod container;
mod error;
mod evidence;
mod export;
mod file;
mod frame;
mod ground;
mod image;
mod localizer;
mod occupancy_grid;
mod sections;
mod visual_map;

pub use align::{Aligned, BetweenError, ScaledBetween};
pub use container::{FORMAT_VERSION, MAX_FILE_BYTES};
pub use error::{Damage, VmapError};
pub use evidence::Hypothesis;
pub use export::{ColmapModel, NerfstudioModel, picture_name};
pub use file::{load, load_fixed, save};
pub use ground::{Ground, find_ground};
pub use image::packing;
pub use localizer::{CameraEstimate, LOCALIZED_RELIABILITY, MapLocalizer, Support};
pub use visual_map::{MapScale, OpenedMap, ScaleSource, Session, VisualMap};
