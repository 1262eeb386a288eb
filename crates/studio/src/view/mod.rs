//! What pages are shown of a robot: the world as geometry, what an algorithm thinks, what the camera sees.

mod localization;
mod polylines;
mod run;
mod theory;
mod world;

pub(crate) use localization::triple;
pub use localization::{ContenderView, LocalizationView, views};
pub use run::{RunMoment, RunViewer};
pub use theory::theoretical_image;
pub use world::world_geometry;
