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
pub use map_show::open_map_show;
pub use show::open_show;
pub use slam_show::open_slam_show;
pub use steering::Steering;
