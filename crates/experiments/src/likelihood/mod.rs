//! Likelihood maps: how well every pose on a map explains one image.
//!
//! [`Eye`] turns a frame into a percept and an observation model, [`LikelihoodMap`] weighs all places with a fixed or the
//! best heading, [`heading_profile`] weighs all headings at one place, [`climb`] walks from a pose to the next peak.
//! [`SimulatedView`] is an image from a given pose. Source: 2010 section 4.4.

mod eye;
mod map;
mod peaks;
mod pictures;
mod view;

pub use eye::Eye;
pub use map::{HeadingChoice, LikelihoodMap, heading_profile};
pub use peaks::{PEAK_DISTANCE_M, Peak, climb, peaks};
pub use pictures::{LikelihoodPictures, map_csv, profile_csv};
pub use view::{SimulatedView, View};
