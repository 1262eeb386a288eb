//! What the program shares with the studio: runs that are recorded and watched, and the page itself.

mod broadcast;
mod command;
mod files;
mod map_show;
mod show;
mod slam_show;
mod steered;
mod steering;

pub use command::execute;
pub use map_show::MapShow;
pub use show::Show;
pub use slam_show::{Shown, SlamShow};
pub use steering::Steering;
