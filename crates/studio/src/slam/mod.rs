//! A camera that makes its own map, to be watched.
//!
//! `viewer` takes moments out of a running system, wherever it runs, and `moment` makes messages of them; `display` takes the map's frame to the one that is shown;
//! `shapes` turns the map into arrays; `session` runs a sequence in the studio, with `images` from anywhere and `parameters` that
//! people change.

mod display;
mod images;
mod moment;
mod parameters;
mod session;
mod shapes;
mod viewer;

pub use images::{ImagesOpener, OpenCamera, SequenceSource};
pub use moment::SlamMoment;
pub use parameters::SlamSettings;
pub use session::SlamSession;
pub use viewer::SlamViewer;
