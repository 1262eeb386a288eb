//! Recordings played, and computed again with other parameters.

mod camera_run;
mod draft;
mod recompute;
mod session;

pub use session::Replay;
