//! A camera that makes its own map, or is found in the map of an earlier session, to be watched.
//!
//! `viewer` takes moments out of a running system, wherever it runs, and `moment` makes messages of them; `display` takes the map's frame to the one that is shown;
//! `shapes` turns the map into arrays; `in_map` adds what is known of a place in an earlier map, in words by `told`. `session` runs a
//! `system` on a sequence in the studio, with `images` from anywhere and `parameters` that people change; what it was `taught` is saved.

mod display;
mod images;
mod in_map;
mod moment;
mod parameters;
mod session;
mod shapes;
mod system;
mod taught;
mod told;
mod viewer;

pub use images::{ImagesOpener, OpenCamera, SequenceSource};
pub use in_map::MapViewer;
pub use moment::SlamMoment;
pub use parameters::SlamSettings;
pub use session::SlamSession;
pub use taught::{Job, TaughtMap, TaughtMaps};
pub use viewer::SlamViewer;
